// SPDX-License-Identifier: MIT OR Apache-2.0
//! What goes wrong on machines: full disks, folders that cannot be written, files that change, processes that are killed,
//! drivers that fail. Nothing torn, nothing left behind, and a sentence that says what happened.
#![cfg(unix)]

mod common;

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant, SystemTime};

use brdf_baker::env::import::{self, Options};
use brdf_baker::progress::Progress;
use common::Random;
use common::program::{command, environment, fails, files, is_whole, on_any_device, said, succeeds, text};
use tempfile::TempDir;

/// Three tables and two environments, small enough to be baked often.
const RECIPE: &str = r#"
output = "out"
[[bake]]
table = "split-sum"
output = "a.ktx2"
size = 8
[[bake]]
table = "split-sum"
output = "b.exr"
size = 8
[[bake]]
table = "albedo"
output = "c.png"
size = 8
[[env]]
input = "lamp.exr"
output = "d.ktx2"
size = 4
[[env]]
input = "lamp.exr"
output = "e.hdr"
kernel = "lambert"
shape = "equirect"
size = 4
"#;
const OUTPUTS: [&str; 5] = ["a.ktx2", "b.exr", "c.png", "d.ktx2", "e.hdr"];

fn studio() -> TempDir {
    let folder = TempDir::new().expect("a folder");
    fs::write(folder.path().join("recipe.toml"), RECIPE).expect("writable");
    environment(&folder.path().join("lamp.exr"), 0.0);
    folder
}

fn signal(name: &str, process: u32) {
    // The shell's own `kill`: a minimal system has no other.
    let sent = Command::new("sh").args(["-c", &format!("kill -{name} {process}")]).stderr(Stdio::null()).status();
    assert!(sent.is_ok());
}

fn quiet(mut command: Command) -> std::process::Child {
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts")
}

/// Runs a script of sh in a name space of its own, where it may mount; `None` where the system does not let it.
fn with_mounts(script: &str, folder: &Path) -> Option<(ExitStatus, String)> {
    let output = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", script, "sh"])
        .args([folder.as_os_str(), env!("CARGO_BIN_EXE_brdf-baker").as_ref()])
        .output();
    let output = output.ok().filter(|output| output.status.code().is_some_and(|code| code != 77))?;
    let said = text(&output.stdout) + &text(&output.stderr);
    // `unshare` itself fails with 1, and no command here does.
    if output.status.code() == Some(1) {
        return None;
    }
    Some((output.status, said))
}

#[test]
fn full_disk_leaves_the_old_file_and_no_other() {
    let folder = TempDir::new().expect("a folder");
    let script = r#"mount -t tmpfs -o size=32k none "$1" || exit 77
        cd "$1" && echo old > a.ktx2
        "$2" bake split-sum --size 96 -o a.ktx2 --device cpu; code=$?
        ls -A; cat a.ktx2; exit $code"#;
    let Some((status, said)) = with_mounts(script, folder.path()) else {
        eprintln!("skipped: mounting is not allowed here");
        return;
    };
    assert_eq!(status.code(), Some(2), "{said}");
    assert!(said.contains("No space left on device") && said.contains("free some space"), "{said}");
    assert!(said.starts_with("a.ktx2\nold\n"), "{said}");
}

#[test]
fn file_that_may_not_grow_is_not_half_written() {
    let folder = TempDir::new().expect("a folder");
    let here = folder.path();
    // Four blocks of 512 or 1024 bytes, and no signal beyond them.
    let script = r#"trap '' XFSZ; ulimit -f 4; exec "$@""#;
    let bake = ["bake", "split-sum", "--size", "64", "-o", "a.ktx2", "--device", "cpu"];
    let output = Command::new("sh")
        .current_dir(here)
        .args(["-c", script, "sh", env!("CARGO_BIN_EXE_brdf-baker")])
        .args(bake)
        .output()
        .expect("sh");
    said(&output, 2, &["cannot write", "a.ktx2", "File too large"]);
    assert!(files(here).is_empty());
}

#[test]
fn read_only_folder_is_refused_before_any_work() {
    let folder = TempDir::new().expect("a folder");
    let script = r#"mount -t tmpfs none "$1" && mount -o remount,ro "$1" || exit 77
        "$2" bake split-sum --size 4096 -o "$1/a.ktx2" --device cpu"#;
    match with_mounts(script, folder.path()) {
        None => eprintln!("skipped: mounting is not allowed here"),
        Some((status, said)) => {
            assert_eq!(status.code(), Some(2), "{said}");
            assert!(said.contains("Read-only file system") && said.contains("choose a folder"), "{said}");
        }
    }
}

#[test]
fn output_that_is_a_folder_is_refused_before_any_work() {
    let studio = studio();
    let here = studio.path();
    fs::create_dir_all(here.join("out/d.ktx2/inside")).expect("writable");
    let bake = ["bake", "split-sum", "--size", "4096", "-o", "out/d.ktx2"];
    fails(&mut command(here, &bake), 2, &["out/d.ktx2", "name a file, not a folder"]);
    fails(&mut command(here, &["run", "recipe.toml"]), 2, &["item 4, env lamp.exr", "name a file", "1 of 5 items"]);
    let rest: Vec<String> = files(&here.join("out")).iter().map(|path| path.display().to_string()).collect();
    assert_eq!(rest, ["a.ktx2", "b.exr", "c.png", "e.hdr"]);
}

#[test]
fn input_that_changes_while_it_is_read_is_refused() {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("a.exr");
    let whole = |seed| {
        environment(&path, seed);
        fs::read(&path).expect("it is there")
    };
    let (first, second) = (whole(0.0), whole(1.0));
    assert_ne!(first, second);
    // Overwritten, cut short, and continued, each at the first look that the reader takes.
    for content in [&second[..], &first[..first.len() / 2], &[&first[..], b"more"].concat()] {
        fs::write(&path, &first).expect("writable");
        // Clocks of file systems tick.
        let earlier = SystemTime::now() - Duration::from_secs(5);
        File::options().append(true).open(&path).and_then(|file| file.set_modified(earlier)).expect("writable");
        let mut changed = false;
        let mut change = |_: Progress<'_>| {
            if !std::mem::replace(&mut changed, true) {
                fs::write(&path, content).expect("writable");
            }
            std::ops::ControlFlow::Continue(())
        };
        let error = import::read(&path, &Options::default(), &mut change).expect_err("it changed");
        assert!(error.to_string().contains("it changed while it was read"), "{error}");
        assert!(error.help().contains("wait until it is written"));
    }
    // Another file under its name does no harm: the one that was opened is whole.
    fs::write(&path, &first).expect("writable");
    let mut replace = |_: Progress<'_>| {
        let new = path.with_extension("new");
        fs::write(&new, "junk").and_then(|()| fs::rename(&new, &path)).expect("writable");
        std::ops::ControlFlow::Continue(())
    };
    import::read(&path, &Options::default(), &mut replace).expect("what was opened");
}

#[test]
fn kill_at_any_moment_leaves_whole_files_and_the_next_run_cleans_up() {
    let studio = studio();
    let here = studio.path();
    let run = || command(here, &["run", "recipe.toml", "--force"]);
    let start = Instant::now();
    succeeds(&mut run());
    let whole_run = start.elapsed();
    let out = here.join("out");
    let mut random = Random(7);
    let (mut started, mut killed, mut left) = (0, 0, 0);
    // Under load a run may end before its time: such a one does not count.
    while killed < 100 {
        started += 1;
        assert!(started < 1000, "only {killed} of {started} were killed at work");
        let mut child = quiet(run());
        std::thread::sleep(whole_run.mul_f64(random.next()));
        child.kill().expect("it was started here");
        let status = child.wait().expect("it ends");
        killed += usize::from(std::os::unix::process::ExitStatusExt::signal(&status) == Some(9));
        for name in OUTPUTS {
            assert!(is_whole(&out.join(name)), "{name}");
        }
        left = files(&out).len() - OUTPUTS.len();
    }
    println!("{killed} of {started} were killed at work; {left} temporary files were left");

    // What is left belongs to nobody, and after a minute the next run removes it.
    for name in files(&out).iter().filter(|name| name.extension().is_some_and(|e| e == "part")) {
        let old = SystemTime::now() - Duration::from_secs(100);
        File::options().append(true).open(out.join(name)).and_then(|file| file.set_modified(old)).expect("writable");
    }
    let said = succeeds(&mut command(here, &["run", "recipe.toml", "--force"]));
    assert!(said.contains("5 baked"), "{said}");
    assert_eq!(files(&out).len(), OUTPUTS.len(), "{:?}", files(&out));
}

#[test]
fn killed_run_goes_on_where_it_ended() {
    let studio = studio();
    let here = studio.path();
    let out = here.join("out");
    let mut child = quiet(command(here, &["run", "recipe.toml"]));
    let start = Instant::now();
    while !out.join("a.ktx2").exists() {
        assert!(start.elapsed().as_secs() < 60, "nothing is baked");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().expect("it was started here");
    child.wait().expect("it ends");
    let done: Vec<_> = OUTPUTS.iter().filter(|name| out.join(name).exists()).collect();
    let said = succeeds(&mut command(here, &["run", "recipe.toml"]));
    let counts = format!("{} baked, {} unchanged", OUTPUTS.len() - done.len(), done.len());
    assert!(said.contains(&counts), "{counts} is not in: {said}");
}

#[test]
fn ctrl_c_ends_a_run_with_whole_files_only() {
    let studio = studio();
    let here = studio.path();
    // The second item takes longer than anybody waits. A farm cancels by SIGTERM.
    let long = RECIPE.replacen("output = \"b.exr\"\nsize = 8", "output = \"b.exr\"\nsize = 4096", 1);
    fs::write(here.join("recipe.toml"), long).expect("writable");
    for name in ["INT", "TERM"] {
        let child = command(here, &["run", "recipe.toml"])
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let start = Instant::now();
        while files(here).iter().filter(|path| path.starts_with("out")).count() < 2 {
            assert!(start.elapsed().as_secs() < 60, "nothing is baked");
            std::thread::sleep(Duration::from_millis(1));
        }
        signal(name, child.id());
        let output = child.wait_with_output().expect("it ends");
        said(&output, 130, &["error: cancelled"]);
        assert_eq!(files(&here.join("out")), [Path::new("a.ktx2")]);
    }
}

#[test]
fn a_hundred_processes_write_into_one_folder() {
    let studio = studio();
    let here = studio.path();
    let (out, alone) = (here.join("out"), here.join("alone"));
    succeeds(&mut command(here, &["run", "recipe.toml", "-o", "alone"]));
    let children: Vec<_> = (0..100)
        .map(|_| {
            let mut run = command(here, &["run", "recipe.toml"]);
            run.env("RAYON_NUM_THREADS", "1").stdout(Stdio::null()).stderr(Stdio::piped());
            run.spawn().expect("the program starts")
        })
        .collect();
    for child in children {
        let output = child.wait_with_output().expect("it ends");
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    assert_eq!(files(&out), files(&alone));
    for name in OUTPUTS {
        assert!(
            fs::read(out.join(name)).expect("it is there") == fs::read(alone.join(name)).expect("it is there"),
            "{name}"
        );
    }
}

#[test]
fn nobody_who_reads_is_no_failure() {
    let folder = TempDir::new().expect("a folder");
    let here = folder.path();
    let closed = |arguments: &[&str]| {
        let mut command = command(here, arguments);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
        // Nobody will read either.
        drop((child.stdout.take(), child.stderr.take()));
        child.wait().expect("it ends").code()
    };
    assert_eq!(closed(&["bake", "albedo", "--size", "8", "-o", "a.ktx2"]), Some(0));
    assert!(is_whole(&here.join("a.ktx2")));
    assert_eq!(closed(&["list"]), Some(0));
    // The warning and the error have no reader; the exit code stays what it is.
    assert_eq!(closed(&["bake", "albedo", "--size", "8", "-o", "a.npy"]), Some(0));
    assert_eq!(closed(&["bake", "albedo", "--size", "8", "-o", "a.unknown"]), Some(2));
    assert_eq!(closed(&["bake", "--nonsense"]), Some(2));
}

#[test]
fn stdout_on_a_full_disk_is_an_error() {
    let folder = TempDir::new().expect("a folder");
    let Ok(full) = File::options().write(true).open("/dev/full") else {
        eprintln!("skipped: this system has no /dev/full");
        return;
    };
    let output = command(folder.path(), &["list"]).stdout(full).output().expect("the program starts");
    said(&output, 2, &["cannot write 'stdout'", "No space left on device"]);
}

/// A bake on a device where this goes wrong.
fn injected(folder: &Path, fault: &str, arguments: &[&str]) -> Command {
    let mut command = on_any_device(folder, arguments);
    command.env("BRDF_BAKER_INJECT", fault);
    command
}

#[test]
fn failing_devices_are_named_and_leave_no_file() {
    if common::gpu().is_none() {
        return;
    }
    let folder = TempDir::new().expect("a folder");
    let here = folder.path();
    environment(&here.join("lamp.exr"), 0.0);
    let table = ["bake", "split-sum", "--size", "8", "-o", "a.ktx2", "--device", "0"];
    let cube = ["env", "lamp.exr", "--size", "8", "-o", "a.ktx2", "--device", "0"];
    for bake in [table, cube] {
        for (fault, words) in [
            ("device-lost=2", &["failed on the GPU: the device was lost", "--device cpu"][..]),
            ("device-memory=1000", &["allocate '", "out of device memory", "--device cpu"]),
            ("max-buffer=100", &["allocate '", "bytes asked for, the device allows up to 100"]),
            ("old-driver=1", &["no Vulkan device has index 0", "found: none", "--device cpu"]),
            ("device-last=2", &["BRDF_BAKER_INJECT asks for 'device-last'", "did you mean 'device-lost'?"]),
        ] {
            fails(&mut injected(here, fault, &bake), 2, words);
            assert_eq!(files(here), [Path::new("lamp.exr")], "{fault}");
        }
        let mut without = on_any_device(here, &bake);
        without.env("VK_DRIVER_FILES", "/nonexistent.json").env("VK_ICD_FILENAMES", "/nonexistent.json");
        fails(&mut without, 2, &["--device cpu"]);
    }
    // Whoever leaves the choice to the program gets the processor, by its name.
    let said = succeeds(&mut injected(here, "old-driver=1", &["bake", "split-sum", "--size", "8", "-o", "a.ktx2"]));
    assert!(said.trim_end().ends_with("cpu"), "{said}");
}

#[test]
fn run_opens_a_lost_device_again() {
    if common::gpu().is_none() {
        return;
    }
    let studio = studio();
    let here = studio.path();
    // The number of submissions after which the first item is done and the second is not is the driver's business.
    let mixed = (2..200).find_map(|lost| {
        let run = ["run", "recipe.toml", "--force", "--json", "--device", "0"];
        let output = injected(here, &format!("device-lost={lost}"), &run).output().expect("the program starts");
        let stdout = text(&output.stdout);
        let count = |outcome: &str| stdout.matches(&format!("\"outcome\":\"{outcome}\"")).count();
        (count("baked") > 0).then(|| (output.status.code(), stdout.clone(), count("baked"), count("failed")))
    });
    let (code, stdout, baked, failed) = mixed.expect("some number lets an item through");
    assert_eq!((code, baked + failed), (Some(2), 5), "{stdout}");
    assert!(stdout.contains("the device was lost"), "{stdout}");
    // One that failed comes before one that was baked: the device was opened anew.
    let outcomes: Vec<bool> = stdout.lines().map(|line| line.contains("\"outcome\":\"baked\"")).collect();
    assert!(outcomes.windows(2).any(|pair| pair == [false, true]), "{stdout}");
}

#[test]
fn damaged_recipe_is_refused() {
    let folder = TempDir::new().expect("a folder");
    let here = folder.path();
    let mut file = File::create(here.join("recipe.toml")).expect("writable");
    file.write_all(b"output = \"a\"\n\xff\n").expect("writable");
    fails(&mut command(here, &["run", "recipe.toml"]), 2, &["line 2 is not UTF-8"]);
    file.set_len(2 << 20).expect("writable");
    fails(&mut command(here, &["run", "recipe.toml"]), 2, &["at most 1048576 bytes"]);
    fails(&mut command(here, &["run", "."]), 2, &["cannot read '.'", "name a file"]);
}
