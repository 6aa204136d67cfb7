//! What a step costs: the ground on which speeds are measured, ours and those of other programs.
//!
//! | program | what it measures |
//! |---|---|
//! | `cargo run --release -p tsutsumi-benches --bin throughput` | particle-steps per second of one block of ground |
//! | `cargo run --release -p tsutsumi-benches --bin column` | time per step of the paper's column |
//! | `python3 benches/peers/compare.py` | the same block and column with other programs, in turns |
//! | `cargo run --release -p tsutsumi-benches --bin dispatch` | what it costs that parts are chosen by name |
//! | `cargo bench -p tsutsumi-benches --bench step` | steps of many kinds, with criterion |
//! | `cargo bench -p tsutsumi-benches --bench laws` | an update of each law |
//! | `cargo run -p tsutsumi-benches --bin instructions` | instructions of the kernels, against a baseline |

pub mod block;
pub mod dispatch;
pub mod instructions;
pub mod kernels;
pub mod laws;
