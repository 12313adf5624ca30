//! What a run tells about itself: times, counters, balances, errors.

mod balance;
mod counters;
mod timers;

pub use balance::{Balance, Flows, Moved};
pub use counters::Counters;
pub use timers::Timers;
