//! The command line from outside: what it prints, writes and returns, and what it says of faults.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod columns;
mod completions;
mod costs;
mod coupled;
mod documented;
mod fault_calls;
mod fault_domains;
mod fault_files;
mod fault_points;
mod fault_rocks;
mod fault_runs;
mod fault_texts;
mod folders;
mod interrupt;
mod limits;
mod listings;
mod mutations;
mod pages;
mod processes;
mod repeats;
mod restart;
mod runs;
mod solver_flags;
mod starts;
mod studies;
mod support;
