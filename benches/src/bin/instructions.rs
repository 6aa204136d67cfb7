//! Counts the instructions of the kernels under valgrind and compares them with the baseline.
//!
//! ```text
//! cargo run -p tsutsumi-benches --bin instructions              # compare
//! cargo run -p tsutsumi-benches --bin instructions -- --accept  # write the baseline anew
//! ```

#![allow(clippy::print_stdout, reason = "it is what the program is for")]

use std::collections::BTreeMap;
use std::env;
use std::error::Error;
use std::fs;
use std::hint::black_box;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

use clap::Parser;
use tsutsumi_benches::instructions::{Change, Counts, Verdict, collected};
use tsutsumi_benches::kernels::{KERNELS, Work};

/// Counts the instructions of the kernels under valgrind and compares them with the baseline.
#[derive(Debug, Parser)]
struct Arguments {
    /// Write what is counted as the new baseline.
    #[arg(long)]
    accept: bool,
    /// Do the work of this kernel and count nothing: what runs under valgrind.
    #[arg(long, value_name = "NAME", conflicts_with = "accept")]
    work: Option<String>,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let arguments = Arguments::parse();
    if let Some(name) = arguments.work {
        return work(&name);
    }
    let counts = Counts { compiler: compiler()?, instructions: count_all()? };
    if arguments.accept {
        fs::write(baseline_path(), serde_json::to_string_pretty(&counts)? + "\n")?;
        println!("{} kernels written to {}", counts.instructions.len(), baseline_path().display());
        return Ok(ExitCode::SUCCESS);
    }
    let baseline: Counts = serde_json::from_str(&fs::read_to_string(baseline_path())?)?;
    Ok(judge(&counts, &baseline))
}

fn baseline_path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("instructions.json")
}

/// Prints every kernel; fails when one is slower and the compiler is that of the baseline.
fn judge(counts: &Counts, baseline: &Counts) -> ExitCode {
    let verdicts = counts.against(baseline);
    verdicts.iter().for_each(|verdict| println!("{verdict}"));
    let same_compiler = counts.compiler == baseline.compiler;
    if !same_compiler {
        println!(
            "compiled by {}, the baseline by {}: no change counts as a failure",
            counts.compiler, baseline.compiler
        );
    }
    if verdicts.iter().any(|verdict| verdict.change() != Change::None) {
        println!("To accept: cargo run -p tsutsumi-benches --bin instructions -- --accept");
    }
    let slower = |verdict: &Verdict| verdict.change() == Change::Slower;
    if same_compiler && verdicts.iter().any(slower) { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// The compiler's version and target, and whether it was told of more than the target's plain instructions.
fn compiler() -> Result<String, Box<dyn Error>> {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let said = String::from_utf8(Command::new(rustc).arg("-vV").output()?.stdout)?;
    let value = |key: &str| said.lines().find_map(|line| line.strip_prefix(key)).unwrap_or("unknown").trim().to_owned();
    let more = if cfg!(target_feature = "avx") { " with AVX" } else { "" };
    Ok(format!("rustc {} for {}{more}", value("release:"), value("host:")))
}

fn count_all() -> Result<BTreeMap<String, u64>, Box<dyn Error>> {
    KERNELS.iter().map(|kernel| Ok((kernel.name.to_owned(), count(kernel.name)?))).collect()
}

/// The instructions of a kernel: this program under callgrind, which counts inside [`counted_work`] only.
fn count(name: &str) -> Result<u64, Box<dyn Error>> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null", "--toggle-collect=*counted_work*"])
        .arg(env::current_exe()?)
        .args(["--work", name])
        .output()
        .map_err(|error| format!("valgrind cannot be started: {error}"))?;
    let messages = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(format!("{name} failed under valgrind:\n{messages}").into());
    }
    match collected(&messages) {
        Some(count) if count > 0 => Ok(count),
        _ => Err(format!("{name}: valgrind counted nothing:\n{messages}").into()),
    }
}

/// Prepares a kernel and does its work once, all on this thread.
fn work(name: &str) -> Result<ExitCode, Box<dyn Error>> {
    let kernel = KERNELS.iter().find(|kernel| kernel.name == name).ok_or_else(|| format!("no kernel `{name}`"))?;
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let mut work = (kernel.prepare)()?;
    counted_work(&mut work);
    Ok(ExitCode::SUCCESS)
}

/// Callgrind finds it by its name.
#[inline(never)]
fn counted_work(work: &mut Work) {
    black_box(work)();
}
