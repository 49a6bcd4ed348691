//! As much of HTTP/1.1 as a page on this machine needs: one request a connection, with bounds on
//! everything that a client may do, in size and in time.
//!
//! Heads are parsed by `httparse`. Servers to be had as crates either bring an asynchronous runtime, or
//! have no time limits for slow clients and start a thread for each that comes (tiny_http).

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

/// The head of a request, in bytes, and how many headers it may have.
const MAX_HEAD: usize = 16 << 10;
const MAX_HEADERS: usize = 64;

/// How long a client may take for a request's head, for its body, and to take a piece of the answer.
const HEAD_TIME: Duration = Duration::from_secs(5);
const BODY_TIME: Duration = Duration::from_secs(20);
const WRITE_TIME: Duration = Duration::from_secs(10);

/// What else a refused client sends is taken for so long, so that it gets to read the answer.
const DRAIN_TIME: Duration = Duration::from_millis(500);

/// A status of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Status {
    Ok,
    NoContent,
    BadRequest,
    Forbidden,
    NotFound,
    MethodNotAllowed,
    RequestTimeout,
    Conflict,
    TooLarge,
    Misdirected,
    HeadTooLarge,
    Failed,
    NotImplemented,
    Busy,
}

impl Status {
    /// Number and name.
    fn line(self) -> &'static str {
        match self {
            Status::Ok => "200 OK",
            Status::NoContent => "204 No Content",
            Status::BadRequest => "400 Bad Request",
            Status::Forbidden => "403 Forbidden",
            Status::NotFound => "404 Not Found",
            Status::MethodNotAllowed => "405 Method Not Allowed",
            Status::RequestTimeout => "408 Request Timeout",
            Status::Conflict => "409 Conflict",
            Status::TooLarge => "413 Content Too Large",
            Status::Misdirected => "421 Misdirected Request",
            Status::HeadTooLarge => "431 Request Header Fields Too Large",
            Status::Failed => "500 Internal Server Error",
            Status::NotImplemented => "501 Not Implemented",
            Status::Busy => "503 Service Unavailable",
        }
    }
}

/// The head of a request, and what of its body came with it.
pub(super) struct Head {
    pub(super) method: String,
    pub(super) target: String,
    headers: Vec<(String, String)>,
    rest: Vec<u8>,
}

impl Head {
    /// The value of a header, if it is there exactly once.
    pub(super) fn header(&self, name: &str) -> Option<&str> {
        let mut values = self.headers.iter().filter(|(other, _)| other.eq_ignore_ascii_case(name));
        let (_, value) = values.next()?;
        values.next().is_none().then_some(value)
    }

    /// Whether a header is there, however often.
    pub(super) fn has(&self, name: &str) -> bool {
        self.headers.iter().any(|(other, _)| other.eq_ignore_ascii_case(name))
    }
}

/// Reads the head of a request; none if the client has gone without asking for anything.
///
/// # Errors
/// The status that the client gets.
pub(super) fn read_head(mut stream: &TcpStream) -> Result<Option<Head>, Status> {
    let deadline = Instant::now() + HEAD_TIME;
    let mut bytes = Vec::new();
    loop {
        let mut piece = [0; 4096];
        let n = read_before(&mut stream, &mut piece, deadline)?;
        if n == 0 {
            return if bytes.is_empty() { Ok(None) } else { Err(Status::BadRequest) };
        }
        bytes.extend_from_slice(&piece[..n]);
        if let Some(head) = parse(&bytes)? {
            return Ok(Some(head));
        }
        if bytes.len() > MAX_HEAD {
            return Err(Status::HeadTooLarge);
        }
    }
}

/// The head at the start of some bytes, if all of it is there.
fn parse(bytes: &[u8]) -> Result<Option<Head>, Status> {
    let mut headers = [httparse::EMPTY_HEADER; MAX_HEADERS];
    let mut request = httparse::Request::new(&mut headers);
    let length = match request.parse(bytes) {
        Ok(httparse::Status::Complete(length)) => length,
        Ok(httparse::Status::Partial) => return Ok(None),
        Err(httparse::Error::TooManyHeaders) => return Err(Status::HeadTooLarge),
        Err(_) => return Err(Status::BadRequest),
    };
    if length > MAX_HEAD {
        return Err(Status::HeadTooLarge);
    }
    let text = |header: &httparse::Header<'_>| {
        let value = std::str::from_utf8(header.value).map_err(|_| Status::BadRequest)?;
        Ok((header.name.to_owned(), value.trim().to_owned()))
    };
    let (method, target) = request.method.zip(request.path).ok_or(Status::BadRequest)?;
    Ok(Some(Head {
        method: method.to_owned(),
        target: target.to_owned(),
        headers: request.headers.iter().map(text).collect::<Result<_, _>>()?,
        rest: bytes[length..].to_vec(),
    }))
}

/// Reads the body that a head announces, of at most so many bytes.
///
/// # Errors
/// The status that the client gets.
pub(super) fn read_body(
    mut stream: &TcpStream,
    head: &mut Head,
    max: usize,
) -> Result<Vec<u8>, Status> {
    if head.has("transfer-encoding") {
        return Err(Status::NotImplemented);
    }
    let length = match head.header("content-length") {
        Some(length) if length.bytes().all(|byte| byte.is_ascii_digit()) => {
            length.parse().unwrap_or(usize::MAX)
        }
        None if !head.has("content-length") => 0,
        _ => return Err(Status::BadRequest),
    };
    if length > max {
        return Err(Status::TooLarge);
    }
    let deadline = Instant::now() + BODY_TIME;
    let mut body = std::mem::take(&mut head.rest);
    body.truncate(length);
    while body.len() < length {
        let mut piece = [0; 16 << 10];
        let wanted = piece.len().min(length - body.len());
        match read_before(&mut stream, &mut piece[..wanted], deadline)? {
            0 => return Err(Status::BadRequest),
            n => body.extend_from_slice(&piece[..n]),
        }
    }
    Ok(body)
}

fn read_before(
    stream: &mut &TcpStream,
    into: &mut [u8],
    deadline: Instant,
) -> Result<usize, Status> {
    let left = deadline.saturating_duration_since(Instant::now());
    if left.is_zero() {
        return Err(Status::RequestTimeout);
    }
    stream.set_read_timeout(Some(left)).map_err(|_| Status::Failed)?;
    match stream.read(into) {
        Ok(n) => Ok(n),
        Err(error) if error.kind() == io::ErrorKind::Interrupted => {
            read_before(stream, into, deadline)
        }
        Err(_) if Instant::now() >= deadline => Err(Status::RequestTimeout),
        Err(_) => Ok(0),
    }
}

/// Writes an answer. `policy` is what the content may do in a browser.
///
/// # Errors
/// When the client does not take it.
pub(super) fn respond(
    mut stream: &TcpStream,
    status: Status,
    media_type: &str,
    policy: &str,
    body: &[u8],
) -> io::Result<()> {
    stream.set_write_timeout(Some(WRITE_TIME))?;
    let length = format!("Content-Length: {}\r\n", body.len());
    stream.write_all(head(status, media_type, policy, &length).as_bytes())?;
    stream.write_all(body)?;
    stream.flush()
}

/// Begins an answer that ends with the connection.
///
/// # Errors
/// When the client does not take it.
pub(super) fn begin_stream(mut stream: &TcpStream, media_type: &str) -> io::Result<()> {
    stream.set_write_timeout(Some(WRITE_TIME))?;
    stream.write_all(head(Status::Ok, media_type, "default-src 'none'", "").as_bytes())
}

fn head(status: Status, media_type: &str, policy: &str, more: &str) -> String {
    format!(
        "HTTP/1.1 {}\r\n\
         Content-Type: {media_type}\r\n\
         Content-Security-Policy: {policy}\r\n\
         X-Content-Type-Options: nosniff\r\n\
         X-Frame-Options: DENY\r\n\
         Referrer-Policy: no-referrer\r\n\
         Cross-Origin-Opener-Policy: same-origin\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\n\
         Cache-Control: no-store\r\n\
         Connection: close\r\n\
         {more}\r\n",
        status.line()
    )
}

/// Ends a connection. What the client still sends is read for a moment: a closed connection with bytes
/// unread is reset, and takes the answer with it.
pub(super) fn end(mut stream: &TcpStream) {
    let deadline = Instant::now() + DRAIN_TIME;
    if stream.shutdown(Shutdown::Write).is_err() {
        return;
    }
    let mut piece = [0; 16 << 10];
    while matches!(read_before(&mut stream, &mut piece, deadline), Ok(n) if n > 0) {}
}
