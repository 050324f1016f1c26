//! A web server for one file, which knows ranges, counts what it sends, and misbehaves on demand.

use std::io::{self, BufRead, BufReader, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// Headers by which a server tells the state of its file, and whether it obeys conditions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tells {
    /// An entity tag; conditions are obeyed.
    Tag,
    /// An entity tag; conditions are ignored.
    TagAlone,
    /// The time of the last change, which does not change: a file that is replaced within the second.
    Time,
    /// Nothing.
    Nothing,
}

/// How the server behaves.
#[derive(Debug, Clone)]
pub struct Behaviour {
    pub tells: Tells,
    /// Every so many requests one fails, each time in another way; 0: none does.
    pub fails_every: u64,
    /// Wait before each answer.
    pub pause: Duration,
    /// Answers ranges with the whole file.
    pub ignores_ranges: bool,
    /// Answers everything with this status.
    pub status: Option<u16>,
    /// Another file takes the place after so many requests.
    pub replaced: Option<(u64, Arc<Vec<u8>>)>,
}

impl Default for Behaviour {
    fn default() -> Self {
        Self {
            tells: Tells::Tag,
            fails_every: 0,
            pause: Duration::ZERO,
            ignores_ranges: false,
            status: None,
            replaced: None,
        }
    }
}

/// A server on this machine, until it is dropped.
pub struct RangeServer {
    shared: Arc<ServerState>,
    address: SocketAddr,
}

struct ServerState {
    file: Arc<Vec<u8>>,
    behaviour: Behaviour,
    requests: AtomicU64,
    /// Bytes of bodies that were sent.
    sent: AtomicU64,
    /// Most requests that were answered at the same time.
    at_once: AtomicU64,
    most_at_once: AtomicU64,
    ended: AtomicBool,
    heads: Mutex<Vec<String>>,
}

impl RangeServer {
    /// Starts a server.
    pub fn start(file: Arc<Vec<u8>>, behaviour: Behaviour) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        let shared = Arc::new(ServerState {
            file,
            behaviour,
            requests: AtomicU64::new(0),
            sent: AtomicU64::new(0),
            at_once: AtomicU64::new(0),
            most_at_once: AtomicU64::new(0),
            ended: AtomicBool::new(false),
            heads: Mutex::default(),
        });
        let state = shared.clone();
        thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                if state.ended.load(Ordering::SeqCst) {
                    return;
                }
                let state = state.clone();
                thread::spawn(move || state.serve(&stream));
            }
        });
        Self { shared, address }
    }

    /// URL of the file, with a secret in its query.
    pub fn url(&self) -> String {
        format!("http://{}/areas/area.hop?signature=HIDDEN", self.address)
    }

    /// Bytes of bodies that were sent since this was asked last.
    pub fn take_sent(&self) -> u64 {
        self.shared.sent.swap(0, Ordering::SeqCst)
    }

    /// Bytes of bodies that were sent so far.
    pub fn sent(&self) -> u64 {
        self.shared.sent.load(Ordering::SeqCst)
    }

    pub fn requests(&self) -> u64 {
        self.shared.requests.load(Ordering::SeqCst)
    }

    pub fn most_at_once(&self) -> u64 {
        self.shared.most_at_once.load(Ordering::SeqCst)
    }

    /// Heads of all requests.
    pub fn heads(&self) -> Vec<String> {
        self.shared.heads.lock().expect("heads").clone()
    }
}

impl Drop for RangeServer {
    fn drop(&mut self) {
        self.shared.ended.store(true, Ordering::SeqCst);
        let _ = TcpStream::connect(self.address);
    }
}

/// A response without its body.
fn head(status: &str, headers: &str, length: usize) -> String {
    format!("HTTP/1.1 {status}\r\n{headers}Content-Length: {length}\r\n\r\n")
}

impl ServerState {
    /// Answers requests of a connection until it ends, or is to fail.
    fn serve(&self, stream: &TcpStream) {
        let _ = stream.set_nodelay(true);
        let mut reader = BufReader::new(stream);
        loop {
            let mut head = String::new();
            while !head.ends_with("\r\n\r\n") {
                if !matches!(reader.read_line(&mut head), Ok(read) if read > 0) {
                    return;
                }
            }
            self.heads.lock().expect("heads").push(head.clone());
            let now = self.at_once.fetch_add(1, Ordering::SeqCst) + 1;
            self.most_at_once.fetch_max(now, Ordering::SeqCst);
            let goes_on = self.answer(&head, stream);
            self.at_once.fetch_sub(1, Ordering::SeqCst);
            if !matches!(goes_on, Ok(true)) {
                return;
            }
        }
    }

    /// Answers a request; whether the connection stays.
    fn answer(&self, request: &str, mut stream: &TcpStream) -> io::Result<bool> {
        let behaviour = &self.behaviour;
        thread::sleep(behaviour.pause);
        let number = self.requests.fetch_add(1, Ordering::SeqCst) + 1;
        let asked = |name: &str| {
            let line =
                request.lines().find(|line| line.to_ascii_lowercase().starts_with(&format!("{name}:")));
            line.map(|line| line[name.len() + 1..].trim().to_owned())
        };

        if request.starts_with("GET /moved") {
            stream.write_all(
                head("302 Found", "Location: /areas/area.hop?signature=HIDDEN\r\n", 0).as_bytes(),
            )?;
            return Ok(true);
        }
        if let Some(status) = behaviour.status {
            stream.write_all(head(&format!("{status} Sorry"), "", 0).as_bytes())?;
            return Ok(true);
        }
        let (file, tag) = match &behaviour.replaced {
            Some((after, other)) if number > *after => (other, "\"two\""),
            _ => (&self.file, "\"one\""),
        };
        let headers = match behaviour.tells {
            Tells::Tag | Tells::TagAlone => format!("ETag: {tag}\r\n"),
            Tells::Time => "Last-Modified: Mon, 02 Nov 2026 10:00:00 GMT\r\n".into(),
            Tells::Nothing => String::new(),
        };
        if behaviour.tells == Tells::Tag {
            if asked("if-match").is_some_and(|wanted| wanted != tag) {
                stream.write_all(head("412 Precondition Failed", "", 0).as_bytes())?;
                return Ok(true);
            }
            if asked("if-none-match").is_some_and(|known| known == tag) {
                stream.write_all(format!("HTTP/1.1 304 Not Modified\r\n{headers}\r\n").as_bytes())?;
                return Ok(true);
            }
        }
        if behaviour.ignores_ranges {
            stream.write_all(head("200 OK", &headers, file.len()).as_bytes())?;
            stream.write_all(file)?;
            return Ok(false);
        }

        let range = asked("range").expect("a range");
        let (first, last) = range.trim_start_matches("bytes=").split_once('-').expect("two ends");
        let (first, last): (usize, usize) = (first.parse().expect("first"), last.parse().expect("last"));
        let end = (last + 1).min(file.len());
        let headers = format!("{headers}Content-Range: bytes {first}-{}/{}\r\n", end - 1, file.len());
        let body = &file[first..end];
        let fails = behaviour.fails_every > 0 && number.is_multiple_of(behaviour.fails_every);

        match (fails, number / behaviour.fails_every.max(1) % 4) {
            (true, 0) => stream.write_all(head("500 Internal Server Error", "", 0).as_bytes())?,
            (true, 1) => {
                stream.write_all(head("429 Too Many Requests", "Retry-After: 0\r\n", 0).as_bytes())?;
            }
            (true, 2) => {
                stream.write_all(head("206 Partial Content", &headers, body.len()).as_bytes())?;
                stream.write_all(&body[..body.len() / 2])?;
                return Ok(false);
            }
            (true, _) => return Ok(false),
            (false, _) => {
                self.sent.fetch_add(body.len() as u64, Ordering::SeqCst);
                stream.write_all(head("206 Partial Content", &headers, body.len()).as_bytes())?;
                stream.write_all(body)?;
            }
        }
        Ok(true)
    }
}
