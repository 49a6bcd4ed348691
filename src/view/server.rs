//! Who may ask the page's server for what.
//!
//! Other pages in the same browser are taken for hostile: they cannot guess the address, whose first
//! part is random; a name of theirs that they point at this machine is not ours (`Host`); and what
//! they send comes with their own `Origin`.

use std::fs;
use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use serde::Deserialize;
use serde_json::{Value, json};

use crate::view::http::{self, Head, Status};
use crate::view::page;
use crate::view::protocol::{Choice, Map, NUMBERS};
use crate::view::session::{File, Session};

/// Connections at a time; a page has two or three. So many more are told that there is no room, and
/// others nothing.
const MAX_CONNECTIONS: usize = 32;
const MAX_REFUSED: usize = 16;

/// The longest body: the text of a scene in JSON, for which a text field would long be too slow.
const MAX_BODY: usize = 8 << 20;

/// So often a stream of events says something, to notice that nobody is there any more.
const HEARTBEAT: Duration = Duration::from_secs(10);

/// What anything but the page may do in a browser: nothing, but for the styles of drawings.
const NOTHING: &str = "default-src 'none'; style-src 'unsafe-inline'; frame-ancestors 'none'";

/// A server, before it serves.
pub(super) struct Server {
    listener: TcpListener,
    port: u16,
    token: String,
    session: Arc<Session>,
}

/// The body of `run`.
#[derive(Deserialize)]
struct RunBody {
    text: String,
    choice: Choice,
}

/// The body of `save`.
#[derive(Deserialize)]
struct SaveBody {
    text: String,
    revision: u64,
}

/// An answer: its status, media type and content.
type Answer = Result<(&'static str, Vec<u8>), (Status, String)>;

impl Server {
    /// Listens on this machine; at any port, if `port` is 0.
    ///
    /// # Errors
    /// When the port is taken, or the system gives no random numbers.
    pub(super) fn new(port: u16, session: Arc<Session>) -> io::Result<Self> {
        let listener = TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port)))?;
        let port = listener.local_addr()?.port();
        Ok(Server { listener, port, token: random()?, session })
    }

    /// The address of the page.
    pub(super) fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.token)
    }

    /// Serves for ever.
    pub(super) fn serve(self) {
        let server = Arc::new(self);
        let n_connections = Arc::new(AtomicUsize::new(0));
        for stream in server.listener.incoming() {
            let Ok(stream) = stream else {
                // Perhaps there are too many files open: that passes.
                thread::sleep(Duration::from_millis(50));
                continue;
            };
            let place = Place::take(&n_connections);
            let server = server.clone();
            if place.number >= MAX_CONNECTIONS + MAX_REFUSED {
                continue;
            }
            // Without a thread the connection is closed.
            let _ = thread::Builder::new().name("connection".to_owned()).spawn(move || {
                if place.number < MAX_CONNECTIONS {
                    server.answer(&stream);
                } else {
                    refuse(&stream, Status::Busy, "too many connections");
                }
                drop(place);
            });
        }
    }

    fn answer(&self, stream: &TcpStream) {
        let mut head = match http::read_head(stream) {
            Ok(Some(head)) => head,
            Ok(None) => return,
            Err(status) => return refuse(stream, status, "this is no request"),
        };
        let path = match self.admitted(&head) {
            Ok(path) => path,
            Err((status, why)) => return refuse(stream, status, &why),
        };
        let (path, query) = path.split_once('?').unwrap_or((&path, ""));
        let written = match (head.method.as_str(), path) {
            ("GET", "") => self.page(stream),
            ("GET", "events") => self.events(stream),
            ("GET", _) => respond(stream, self.get(path, query)),
            ("POST", "run" | "save") => {
                let body = http::read_body(stream, &mut head, MAX_BODY);
                let answer = body.map_err(|status| (status, "expected a shorter body".to_owned()));
                respond(stream, answer.and_then(|body| self.post(path, &body)))
            }
            ("POST", _) => respond(stream, Err(not_found())),
            _ => respond(stream, Err((Status::MethodNotAllowed, "GET or POST".to_owned()))),
        };
        if written.is_ok() {
            http::end(stream);
        }
    }

    /// What is asked for, below the random part, if whoever asks may.
    fn admitted(&self, head: &Head) -> Result<String, (Status, String)> {
        let ours = [format!("127.0.0.1:{}", self.port), format!("localhost:{}", self.port)];
        let host = head.header("host").ok_or((Status::BadRequest, "no host".to_owned()))?;
        if !ours.iter().any(|our| our.eq_ignore_ascii_case(host)) {
            return Err((Status::Misdirected, "this host is not served here".to_owned()));
        }
        let rest = head.target.strip_prefix('/').unwrap_or_default();
        let (token, path) = rest.split_once('/').unwrap_or((rest, ""));
        if !is_same(token, &self.token) {
            return Err(not_found());
        }
        if head.method == "POST" {
            let is_json = head.header("content-type").is_some_and(|t| t == "application/json");
            let origins = ours.map(|our| format!("http://{our}"));
            let is_ours = match head.header("origin") {
                Some(origin) => origins.iter().any(|our| our == origin),
                None => !head.has("origin"),
            };
            if !(is_json && is_ours) {
                return Err((Status::Forbidden, "not from the page".to_owned()));
            }
        }
        Ok(path.to_owned())
    }

    fn page(&self, stream: &TcpStream) -> io::Result<()> {
        let nonce = random()?;
        let policy = format!(
            "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; \
             img-src 'self'; connect-src 'self'; base-uri 'none'; form-action 'none'; \
             frame-ancestors 'none'"
        );
        let page = page::with_nonce(&nonce);
        http::respond(stream, Status::Ok, "text/html; charset=utf-8", &policy, page.as_bytes())
    }

    /// Tells events as they come, until the client is gone.
    fn events(&self, mut stream: &TcpStream) -> io::Result<()> {
        http::begin_stream(stream, "text/event-stream; charset=utf-8")?;
        let mut number = 0;
        loop {
            let events = self.session.events_after(number, HEARTBEAT);
            let mut text = String::new();
            for event in &events {
                number = number.max(event.number);
                text += &format!("data: {}\n\n", event.text);
            }
            if events.is_empty() {
                text += ":\n\n";
            }
            stream.write_all(text.as_bytes())?;
        }
    }

    fn get(&self, path: &str, query: &str) -> Answer {
        if let Some(number) = path.strip_prefix("file/").and_then(|number| number.parse().ok()) {
            // A page that asks for what has been overtaken meanwhile has done nothing wrong.
            let event = self.session.event(number).ok_or((Status::NoContent, String::new()))?;
            let File { media_type, bytes } = event.file.as_ref().ok_or_else(not_found)?;
            return Ok((known_type(media_type)?, bytes.clone()));
        }
        if let Some((media_type, content)) = page::on_demand(path) {
            return Ok((media_type, content.into()));
        }
        let value = |name: &str| {
            let mut pairs = query.split('&').filter_map(|pair| pair.split_once('='));
            pairs.find(|(n, _)| *n == name).map(|(_, value)| value)
        };
        let number = |name: &str| value(name).and_then(|value| value.parse::<u32>().ok());
        if path == "map" {
            let asked = (number("run"), number("image"), value("of").and_then(Map::named));
            let (Some(run), Some(image), Some(map)) = asked else {
                return Err((Status::BadRequest, "expected run, image and of".to_owned()));
            };
            let map = self.session.map(run.into(), image as usize, map);
            return match map.ok_or((Status::NoContent, String::new()))? {
                (_, Some(File { media_type, bytes })) => Ok((known_type(&media_type)?, bytes)),
                (why, None) => Ok(of_json(&why)),
            };
        }
        if path == "pixel" {
            let asked = (number("run"), number("image"), number("x"), number("y"));
            let (Some(run), Some(image), Some(x), Some(y)) = asked else {
                return Err((Status::BadRequest, "expected run, image, x and y".to_owned()));
            };
            let pixel = self.session.pixel(run.into(), image as usize, x, y);
            return Ok(of_json(&pixel));
        }
        Err(not_found())
    }

    fn post(&self, path: &str, body: &[u8]) -> Answer {
        let bad = |error: serde_json::Error| (Status::BadRequest, error.to_string());
        if path == "save" {
            let SaveBody { text, revision } = serde_json::from_slice(body).map_err(bad)?;
            let revision = self.session.save(&text, revision)?;
            return Ok(of_json(&json!({ "revision": revision })));
        }
        let RunBody { text, choice } = serde_json::from_slice(body).map_err(bad)?;
        let run = self.session.run(&text, choice);
        let run = run.map_err(|status| (status, "there is no such method".to_owned()))?;
        Ok(of_json(&json!({ "run": run })))
    }
}

/// A connection's place among those that there are.
struct Place {
    taken: Arc<AtomicUsize>,
    /// How many there were before it.
    number: usize,
}

impl Place {
    fn take(taken: &Arc<AtomicUsize>) -> Self {
        Place { number: taken.fetch_add(1, Ordering::Relaxed), taken: taken.clone() }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.taken.fetch_sub(1, Ordering::Relaxed);
    }
}

fn of_json(value: &Value) -> (&'static str, Vec<u8>) {
    ("application/json", value.to_string().into_bytes())
}

/// The media type of a worker's file, if it is one that a page takes.
fn known_type(media_type: &str) -> Result<&'static str, (Status, String)> {
    let known = ["image/png", "image/svg+xml", "application/json", NUMBERS];
    known.into_iter().find(|known| *known == media_type).ok_or_else(not_found)
}

fn not_found() -> (Status, String) {
    (Status::NotFound, "there is nothing here".to_owned())
}

fn respond(stream: &TcpStream, answer: Answer) -> io::Result<()> {
    match answer {
        Ok((media_type, body)) => http::respond(stream, Status::Ok, media_type, NOTHING, &body),
        Err((status, why)) => {
            let is_empty = status == Status::NoContent;
            let body = if is_empty { String::new() } else { json!({ "error": why }).to_string() };
            http::respond(stream, status, "application/json", NOTHING, body.as_bytes())
        }
    }
}

fn refuse(stream: &TcpStream, status: Status, why: &str) {
    if respond(stream, Err((status, why.to_owned()))).is_ok() {
        http::end(stream);
    }
}

/// Compares in a time that does not tell where the difference is.
fn is_same(one: &str, other: &str) -> bool {
    let differences = one.bytes().zip(other.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
    one.len() == other.len() && differences == 0
}

/// 128 random bits in hexadecimal digits.
fn random() -> io::Result<String> {
    let mut bytes = [0; 16];
    fs::File::open("/dev/urandom")?.read_exact(&mut bytes)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
