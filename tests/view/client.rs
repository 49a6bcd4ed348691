//! A server of a page, started for a test, and a client that may also misbehave.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::gmlvm::Sandbox;

/// Longer than anything takes, on a machine that does other things as well.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// An answer of the server.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) status: u16,
    pub(crate) head: String,
    pub(crate) body: Vec<u8>,
}

impl Answer {
    pub(crate) fn json(&self) -> Value {
        let text = || String::from_utf8_lossy(&self.body);
        serde_json::from_slice(&self.body).unwrap_or_else(|error| panic!("{error}: {}", text()))
    }
}

/// A server, ended with the test.
pub(crate) struct Server {
    child: Child,
    pub(crate) port: u16,
    pub(crate) token: String,
}

impl Server {
    pub(crate) fn start(sandbox: &Sandbox, args: &[&str]) -> Self {
        let args: Vec<&str> = [&["view"], args].concat();
        let mut command = sandbox.command(&args);
        let mut child =
            command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("it runs");
        let mut line = String::new();
        let output = child.stdout.as_mut().expect("piped");
        BufReader::new(output).read_line(&mut line).expect("an address");
        let rest = line.trim_end().strip_prefix("http://127.0.0.1:").expect("an address");
        let (port, token) = rest.split_once('/').expect("a token");
        let (port, token) = (port.parse().expect("a port"), token.trim_end_matches('/').to_owned());
        Server { child, port, token }
    }

    pub(crate) fn pid(&self) -> u32 {
        self.child.id()
    }

    pub(crate) fn kill(&mut self) {
        self.child.kill().expect("it runs");
        self.child.wait().expect("it ends");
    }

    /// The memory that the server, without its workers, has in use, in bytes.
    pub(crate) fn resident(&self) -> u64 {
        let status = fs::read_to_string(format!("/proc/{}/status", self.pid())).expect("it runs");
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("a size");
        let kilobytes = line.trim().trim_end_matches(" kB").parse::<u64>();
        kilobytes.expect("a number") * 1024
    }

    pub(crate) fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).expect("it listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a time");
        stream
    }

    /// Sends these bytes, and returns what comes back.
    pub(crate) fn raw(&self, request: &[u8]) -> Answer {
        let mut stream = self.connect();
        // It may be refused before it is all sent.
        let _ = stream.write_all(request);
        answer(&mut stream)
    }

    /// The head of a request for something below the token, with more headers.
    pub(crate) fn head(&self, method: &str, path: &str, headers: &str) -> String {
        let Server { port, token, .. } = self;
        format!("{method} /{token}/{path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n{headers}\r\n")
    }

    pub(crate) fn get(&self, path: &str) -> Answer {
        self.raw(self.head("GET", path, "").as_bytes())
    }

    pub(crate) fn post(&self, path: &str, body: &Value) -> Answer {
        self.post_from(path, body, "")
    }

    pub(crate) fn post_from(&self, path: &str, body: &Value, headers: &str) -> Answer {
        let body = body.to_string();
        let n = body.len();
        let headers = format!("Content-Type: application/json\r\nContent-Length: {n}\r\n{headers}");
        self.raw((self.head("POST", path, &headers) + &body).as_bytes())
    }

    /// Has a text rendered; returns the number of the run.
    pub(crate) fn run(&self, text: &str) -> u64 {
        let answer = self.post("run", &json!({ "text": text, "choice": choice() }));
        assert_eq!(answer.status, 200, "{answer:?}");
        answer.json()["run"].as_u64().expect("a number")
    }

    pub(crate) fn events(&self) -> Events {
        let mut stream = self.connect();
        stream.write_all(self.head("GET", "events", "").as_bytes()).expect("sent");
        let mut reader = BufReader::new(stream);
        let mut line = String::new();
        while line != "\r\n" {
            line.clear();
            assert_ne!(reader.read_line(&mut line).expect("a head"), 0, "no events");
        }
        Events(reader)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The usual choice of a method.
pub(crate) fn choice() -> Value {
    json!({ "engine": "auto", "precision": "f64", "sampling": "centre" })
}

/// What comes back on a connection until it ends.
pub(crate) fn answer(stream: &mut TcpStream) -> Answer {
    let mut bytes = Vec::new();
    let read = stream.read_to_end(&mut bytes);
    let end = bytes.windows(4).position(|four| four == b"\r\n\r\n");
    let end = end.unwrap_or_else(|| panic!("{read:?}: {}", String::from_utf8_lossy(&bytes)));
    let head = String::from_utf8(bytes[..end].to_vec()).expect("text");
    let status = head.split(' ').nth(1).and_then(|status| status.parse().ok());
    Answer { status: status.expect("a status"), head, body: bytes[end + 4..].to_vec() }
}

/// A stream of events.
pub(crate) struct Events(BufReader<TcpStream>);

impl Events {
    pub(crate) fn next(&mut self) -> Value {
        loop {
            let mut line = String::new();
            assert_ne!(self.0.read_line(&mut line).expect("an event in time"), 0, "it ended");
            if let Some(data) = line.strip_prefix("data: ") {
                return serde_json::from_str(data).expect("JSON");
            }
        }
    }

    /// Reads on to an event of this kind, of this run.
    pub(crate) fn until(&mut self, kind: &str, run: u64) -> Value {
        let begun = Instant::now();
        loop {
            let event = self.next();
            if event["event"] == kind && event["run"] == run {
                return event;
            }
            assert!(begun.elapsed() < PATIENCE, "no {kind} of run {run}");
        }
    }

    /// Reads on to the end of a run; returns all events of it.
    pub(crate) fn all_of(&mut self, run: u64) -> Vec<Value> {
        let mut events = Vec::new();
        loop {
            let event = self.next();
            let is_end = event["event"] == "ended";
            if event["run"] == run {
                events.push(event);
                if is_end {
                    return events;
                }
            }
        }
    }
}
