//! What a run tells about itself: times, counters, balances, errors.

mod balance;
mod counters;
mod lenient;
mod motion;
mod supply;
mod timers;

pub use balance::{Balance, BalanceRecord, Flows, Moved};
pub use counters::Counters;
pub use lenient::lenient;
pub use motion::{Balanced, Moment, Motion};
pub use supply::{Ledger, Supply};
pub use timers::Timers;
