//! What faults are injected into: an area, a path, and what an undisturbed run makes of them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::time::{Duration, Instant};
use std::{fs, thread};

use tempfile::TempDir;

/// Longest that a run may take before it counts as hung; an undisturbed one takes a fraction of a second.
const PATIENCE: Duration = Duration::from_secs(60);
/// Posts of the area: several pages of the finest level.
const POSTS: (u32, u32) = (520, 300);

pub fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hedgehop"));
    command.stdin(Stdio::null());
    command
}

/// Inputs, and what an undisturbed run makes of them.
pub struct Site {
    folder: TempDir,
    /// The database.
    pub area: Vec<u8>,
    /// Frames as PNG, by file name.
    pub frames: BTreeMap<String, Vec<u8>>,
    /// The same frames as y4m.
    pub stream: Vec<u8>,
    /// What a build takes.
    pub build_time: Duration,
    /// What a render takes.
    pub render_time: Duration,
}

impl Site {
    pub fn new() -> Self {
        let folder = TempDir::new().expect("a temporary folder");
        let mut site = Self {
            folder,
            area: Vec::new(),
            frames: BTreeMap::new(),
            stream: Vec::new(),
            build_time: Duration::ZERO,
            render_time: Duration::ZERO,
        };

        let (columns, rows) = POSTS;
        let mut grid = format!("ncols {columns}\nnrows {rows}\nxllcorner 0\nyllcorner 0\ncellsize 10\n");
        for row in 0..rows {
            let height = |column: u32| {
                let (x, y) = (f64::from(column) * 0.05, f64::from(row) * 0.07);
                format!("{:.2}", 100.0 + 40.0 * x.sin() + 30.0 * y.cos() + 5.0 * (2.3 * x + y).sin())
            };
            grid += &(0..columns).map(height).collect::<Vec<_>>().join(" ");
            grid.push('\n');
        }

        fs::write(site.path("dem.asc"), grid).expect("the grid is written");
        let path = "t_s,x_m,y_m,alt_agl_m\n0,500,700,60\n1,1200,1300,60\n2,3900,2000,60\n";
        fs::write(site.path("path.csv"), path).expect("the path is written");
        let begun = Instant::now();
        let built = run(site.build(site.path("."), "area.hop"));
        site.build_time = begun.elapsed();
        assert!(built.status.success(), "{}", stderr(&built));
        site.area = fs::read(site.path("area.hop")).expect("the database");
        let begun = Instant::now();
        let rendered = run(site.render(&site.path("area.hop"), "whole/####.png"));
        site.render_time = begun.elapsed();
        assert!(rendered.status.success(), "{}", stderr(&rendered));
        site.frames = frames_in(&site.path("whole"));
        let streamed = run(site.stream_of(&site.path("area.hop")));
        assert!(streamed.status.success(), "{}", stderr(&streamed));
        site.stream = streamed.stdout;

        site
    }

    pub fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A new folder.
    pub fn fresh(&self, name: &str) -> PathBuf {
        let folder = self.path(name);
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).expect("a folder");
        folder
    }

    /// Builds the database `output` in `folder`.
    pub fn build(&self, folder: impl AsRef<Path>, output: &str) -> Command {
        let mut command = program();
        command.current_dir(folder).arg("build").arg("--elevation").arg(self.path("dem.asc"));
        command.args(["--local", "--progress", "none", "-o", output]);
        command
    }

    /// Renders the path as y4m to standard output, in pictures of which a pipe holds none.
    pub fn stream_of(&self, area: &Path) -> Command {
        let mut command = self.render(area, "-");
        command.args(["--size", "320x180"]);
        command
    }

    /// Renders the path to `output`.
    pub fn render(&self, area: &Path, output: &str) -> Command {
        let mut command = program();
        command.current_dir(self.folder.path()).arg("render").arg(area);
        command.args([
            "--path",
            "path.csv",
            "--fps",
            "4",
            "--size",
            "96x54",
            "--progress=none",
            "-o",
            output,
        ]);
        command
    }
}

/// PNG files of a folder; none if there is no folder.
pub fn frames_in(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let Ok(entries) = fs::read_dir(folder) else { return BTreeMap::new() };
    entries
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .filter(|name| name.ends_with(".png") && !name.starts_with('.'))
        .map(|name| (name.clone(), fs::read(folder.join(&name)).expect("a frame")))
        .collect()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Starts a command whose output is kept.
pub fn start(mut command: Command) -> Child {
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts")
}

/// Waits for the end, but not for ever: a hung program is killed, and has died of a signal then.
pub fn finish(mut child: Child) -> Output {
    let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
    let drain = |stream: Option<Box<dyn std::io::Read + Send>>| {
        thread::spawn(move || {
            let mut bytes = Vec::new();
            if let Some(mut stream) = stream {
                let _ = stream.read_to_end(&mut bytes);
            }
            bytes
        })
    };
    let stdout = drain(stdout.map(|stream| Box::new(stream) as _));
    let stderr = drain(stderr.map(|stream| Box::new(stream) as _));
    let status = wait(&mut child);
    let bytes = |thread: thread::JoinHandle<Vec<u8>>| thread.join().expect("its output");
    Output { status, stdout: bytes(stdout), stderr: bytes(stderr) }
}

fn wait(child: &mut Child) -> ExitStatus {
    let begun = Instant::now();
    while child.try_wait().expect("a status").is_none() && begun.elapsed() < PATIENCE {
        thread::sleep(Duration::from_millis(1));
    }
    let _ = child.kill();
    child.wait().expect("a status")
}

pub fn run(command: Command) -> Output {
    finish(start(command))
}
