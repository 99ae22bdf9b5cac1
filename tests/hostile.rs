// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files that nobody vouches for: the corpus of `fuzz/` and small changes of it. Nothing may panic, take long, or take more
//! memory than stated.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use peak_alloc::PeakAlloc;

mod common;
#[path = "../fuzz/targets.rs"]
mod targets;

use common::Random;
use targets::{ALLOWANCE, TARGETS, Target, multiple};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Changes of each file of the corpus, unless HOSTILE_CHANGES is another number. HOSTILE_SEED makes others.
const CHANGES: u64 = 150;
/// No file of the corpus takes a hundredth of this.
const MOST_TIME: Duration = Duration::from_secs(5);

fn corpus(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target);
    let entries = fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("a readable folder").path()).collect();
    paths.sort();
    paths.into_iter().map(|path| (path.clone(), fs::read(path).expect("readable"))).collect()
}

/// A change that damage or malice could make.
fn changed(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for _ in 0..1 + (3.0 * random.next()) as usize {
        let mut at = |len: usize| (random.next() * len as f64) as usize;
        if out.is_empty() {
            return out;
        }
        match at(6) {
            0 => out.truncate(at(out.len())),
            1 => {
                let i = at(out.len());
                out[i] ^= 1 << at(8);
            }
            2 => {
                let (from, to) = (at(out.len()), at(out.len()));
                let piece = out[from..(from + at(64)).min(bytes.len()).max(from).min(out.len())].to_vec();
                out.splice(to..to, piece);
            }
            3 => {
                let from = at(out.len());
                out.drain(from..(from + 1 + at(32)).min(out.len()));
            }
            // Numbers that sizes and offsets break at, in the header more often than elsewhere.
            kind => {
                let most = if kind == 4 { out.len().min(160) } else { out.len() };
                let values =
                    [0, 1, 2, 6, 255, 256, 0x7fff, 0x8000, 0xffff, 0x10000, 0x7fff_ffff, 0x8000_0000, u32::MAX];
                let (i, value) = (at(most), values[at(values.len())]);
                let width = [1, 2, 4, 4][at(4)].min(out.len() - i);
                out[i..i + width].copy_from_slice(&value.to_le_bytes()[..width]);
            }
        }
    }
    out
}

/// What running a target did beyond what it may.
fn broken(target: &Target, bytes: &[u8]) -> Option<String> {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let start = Instant::now();
    let run = target.run;
    if std::panic::catch_unwind(|| run(bytes)).is_err() {
        return Some("panics".into());
    }
    let (taken, time) = (MEMORY.peak_usage().saturating_sub(before), start.elapsed());
    let most = multiple(target.name, bytes).saturating_mul(bytes.len()).saturating_add(ALLOWANCE);
    if taken > most {
        return Some(format!("takes {taken} bytes of memory for {} of the file, more than {most}", bytes.len()));
    }
    (time > MOST_TIME).then(|| format!("takes {time:?}"))
}

/// One test, so that nothing else takes memory meanwhile.
#[test]
fn no_file_breaks_a_reader() {
    hunger_and_panics_are_seen();

    // A target that never ends must fail too: it runs beside.
    let (send, receive) = channel();
    let work = std::thread::spawn(move || {
        let say = |what: String| send.send(what).expect("the test listens");
        let given = |key: &str, usual: u64| match std::env::var(key) {
            Ok(text) => text.parse().unwrap_or_else(|e| panic!("{key}={text}: {e}")),
            Err(_) => usual,
        };
        let (changes, seed) = (given("HOSTILE_CHANGES", CHANGES), given("HOSTILE_SEED", 1));
        for target in &TARGETS {
            let files = corpus(target.name);
            assert!(files.len() >= 2, "{} has a corpus of {} files", target.name, files.len());
            let accepted = files.iter().filter(|(_, bytes)| (target.run)(bytes)).count();
            assert!(accepted >= 1, "{}: only {accepted} files of the corpus are read", target.name);
            let mut random = Random(seed);
            for (path, bytes) in &files {
                say(format!("{} on {}", target.name, path.display()));
                let broken_by = |bytes: &[u8], how: &str| {
                    if let Some(what) = broken(target, bytes) {
                        let kept = std::env::temp_dir().join(format!("hostile-{}", target.name));
                        fs::write(&kept, bytes).expect("the folder is writable");
                        panic!("{} {what}: {} {how}, kept as {}", target.name, path.display(), kept.display());
                    }
                };
                broken_by(bytes, "as it is");
                for cut in 0..24 {
                    broken_by(&bytes[..bytes.len() * cut / 24], "cut short");
                }
                for i in 0..changes {
                    if i % 1000 == 999 {
                        say(format!("{} on {}, change {i}", target.name, path.display()));
                    }
                    broken_by(&changed(bytes, &mut random), "changed");
                }
            }
        }
    });
    let mut last = String::from("nothing");
    loop {
        match receive.recv_timeout(20 * MOST_TIME) {
            Ok(what) => last = what,
            Err(RecvTimeoutError::Timeout) => panic!("no end of {last}"),
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    if let Err(panic) = work.join() {
        std::panic::resume_unwind(panic);
    }
}

fn hunger_and_panics_are_seen() {
    let hungry = Target { name: "hungry", run: |_| Vec::<u8>::with_capacity(64 << 20).capacity() == 0 };
    assert!(broken(&hungry, &[]).is_some_and(|what| what.contains("memory")));
    let panicking = Target { name: "panicking", run: |bytes| bytes[0] == 0 };
    assert_eq!(broken(&panicking, &[]), Some("panics".into()));
}
