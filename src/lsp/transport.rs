//! Messages over a pair of streams: a header with their length, an empty line, and JSON.
//!
//! What is read is not trusted. A length is believed only as far as bytes follow it, and a message that is
//! no JSON is an answer to give, not an end.

use std::io::{self, BufRead, Read, Write};

use serde_json::Value;

use crate::lsp::message::{ErrorCode, Message, ResponseError, response};

/// The longest message: a text of the greatest length in JSON, each byte escaped.
const MAX_MESSAGE: u64 = 6 * compiler::source::MAX_SOURCE_BYTES as u64 + (1 << 20);

/// The longest line of a header.
const MAX_HEADER: u64 = 1 << 12;

/// What a client has sent.
#[derive(Debug)]
pub(super) enum Received {
    Message(Message),
    /// Something in the length of a message that is none; what to answer.
    Broken(Value),
}

/// Reads a message; `None` at the end of the stream.
///
/// # Errors
/// When the stream ends within a message or does not say how long one is: where the next one starts
/// is not known then.
pub(super) fn read(stream: &mut impl BufRead) -> io::Result<Option<Received>> {
    let Some(length) = header(stream)? else { return Ok(None) };
    let mut body = Vec::new();
    stream.take(length).read_to_end(&mut body)?;
    if body.len() as u64 != length {
        return Err(invalid("the stream ends within a message"));
    }
    Ok(Some(match serde_json::from_slice::<Value>(&body) {
        Ok(value) => message(value),
        Err(error) => Received::Broken(refusal(&Value::Null, ErrorCode::ParseError, &error)),
    }))
}

fn message(value: Value) -> Received {
    let id = value.get("id").cloned().unwrap_or_default();
    match serde_json::from_value(value) {
        Ok(message) => Received::Message(message),
        Err(error) => Received::Broken(refusal(&id, ErrorCode::InvalidRequest, &error)),
    }
}

fn refusal(id: &Value, code: ErrorCode, error: &serde_json::Error) -> Value {
    response(id, &Err(ResponseError::new(code, error)))
}

/// The length that a header states; `None` at the end of the stream.
fn header(stream: &mut impl BufRead) -> io::Result<Option<u64>> {
    let mut length = None;
    for n_lines in 0.. {
        let mut line = Vec::new();
        stream.take(MAX_HEADER).read_until(b'\n', &mut line)?;
        if line.is_empty() && n_lines == 0 {
            return Ok(None);
        }
        let text = line.strip_suffix(b"\n").ok_or_else(|| invalid("a header without an end"))?;
        let text = String::from_utf8_lossy(text.strip_suffix(b"\r").unwrap_or(text));
        if text.is_empty() {
            break;
        }
        let (name, value) =
            text.split_once(':').ok_or_else(|| invalid("a line of a header without a colon"))?;
        if name.eq_ignore_ascii_case("content-length") {
            let number = value.trim().parse().ok().filter(|&number| number <= MAX_MESSAGE);
            length = Some(number.ok_or_else(|| invalid("a length that cannot be"))?);
        }
    }
    length.map(Some).ok_or_else(|| invalid("a message without `Content-Length`"))
}

fn invalid(reason: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, reason)
}

/// Writes a message.
pub(super) fn write(stream: &mut impl Write, message: &Value) -> io::Result<()> {
    let text = message.to_string();
    write!(stream, "Content-Length: {}\r\n\r\n{text}", text.len())?;
    stream.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_all(mut bytes: &[u8]) -> Vec<String> {
        let mut found = Vec::new();
        loop {
            let shown = match read(&mut bytes) {
                Ok(None) => return found,
                Ok(Some(Received::Message(Message::Request(request)))) => request.method,
                Ok(Some(Received::Message(other))) => format!("{other:?}"),
                Ok(Some(Received::Broken(answer))) => answer["error"]["code"].to_string(),
                Err(error) => {
                    found.push(error.to_string());
                    return found;
                }
            };
            found.push(shown);
        }
    }

    #[test]
    fn what_is_broken_is_answered_as_long_as_its_end_is_known() {
        let framed = |body: &str| format!("Content-Length: {}\r\n\r\n{body}", body.len());
        let good = framed(r#"{"jsonrpc":"2.0","id":1,"method":"a"}"#);
        let broken = framed("{");
        let no_message = framed(r#"{"id":7,"params":3}"#);
        let deep = framed(&"[".repeat(100_000));
        let all = format!("{good}{broken}{no_message}{deep}{good}");
        assert_eq!(read_all(all.as_bytes()), ["a", "-32700", "-32600", "-32700", "a"]);
        let lower = good.replace("Content-Length: ", "content-type: x\ncontent-length:");
        assert_eq!(read_all(lower.as_bytes()), ["a"]);
        let ends = [
            (&good[..good.len() - 1], "the stream ends within a message"),
            ("Content-Length: 18446744073709551615\r\n\r\n", "a length that cannot be"),
            ("Content-Length: -1\r\n\r\n", "a length that cannot be"),
            ("Content-Length: 999999\r\n\r\n{", "the stream ends within a message"),
            ("\r\n{}", "a message without `Content-Length`"),
            ("GET / HTTP/1.1", "a header without an end"),
            ("nonsense\r\n\r\n", "a line of a header without a colon"),
        ];
        for (bytes, expected) in ends {
            assert_eq!(read_all(bytes.as_bytes()), [expected], "{bytes}");
        }
        assert_eq!(read_all(&vec![b'x'; 1 << 20]), ["a header without an end"]);
    }
}
