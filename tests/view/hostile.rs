//! Clients that are not the page.

use std::io::Write;
use std::net::TcpStream;
use std::time::{Duration, Instant};

use serde_json::json;

use crate::client::{Server, answer, choice};
use crate::gmlvm::{Sandbox, ball};

/// As in `src/view/server.rs` and `src/view/http.rs`.
const MAX_CONNECTIONS: usize = 32;
const HEAD_TIME: Duration = Duration::from_secs(5);

fn server() -> (Sandbox, Server) {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm"));
    let server = Server::start(&sandbox, &["s.gml", "--edit"]);
    (sandbox, server)
}

#[test]
fn the_page_is_one_file_that_may_do_little() {
    let (_sandbox, server) = server();
    let page = server.get("");
    let text = String::from_utf8(page.body).expect("text");
    assert_eq!(page.status, 200);
    assert!(text.len() <= 40_000, "{} bytes", text.len());
    let policy = page.head.lines().find_map(|line| line.strip_prefix("Content-Security-Policy: "));
    let policy = policy.expect("a policy");
    assert!(policy.starts_with("default-src 'none';") && !policy.contains("unsafe"), "{policy}");
    let nonce = policy.split("script-src 'nonce-").nth(1).and_then(|rest| rest.split('\'').next());
    let nonce = nonce.expect("a nonce");
    assert!(text.contains(&format!("<script nonce=\"{nonce}\">")));
    for header in [
        "X-Content-Type-Options: nosniff",
        "Referrer-Policy: no-referrer",
        "X-Frame-Options: DENY",
        "Cross-Origin-Resource-Policy: same-origin",
        "Cache-Control: no-store",
    ] {
        assert!(page.head.contains(header), "{header}");
    }
    let again = String::from_utf8(server.get("").body).expect("text");
    assert!(!again.contains(nonce), "each page has its own");
}

#[test]
fn addresses_cannot_be_guessed() {
    let (_sandbox, server) = server();
    let token = &server.token;
    assert!(token.len() == 32 && token.bytes().all(|byte| byte.is_ascii_hexdigit()));
    let get = |target: &str| {
        let request = format!("GET {target} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\n\r\n", server.port);
        server.raw(request.as_bytes()).status
    };
    assert_eq!(get(&format!("/{token}/")), 200);
    let (half, longer) = (&token[..16], format!("{token}0"));
    let other = token.replace(&token[31..], if token.ends_with('0') { "1" } else { "0" });
    for wrong in ["", half, &longer, &other, "favicon.ico", ".."] {
        for path in ["", "events", "pixel", "map", "file/1", "icon.svg", "chart.js", "compare.js"] {
            assert_eq!(get(&format!("/{wrong}/{path}")), 404, "{wrong} {path}");
        }
    }
    assert_eq!(get("/"), 404);
    // No two servers have the same.
    let other = self::server();
    assert_ne!(*token, other.1.token);
}

#[test]
fn other_names_and_other_pages_are_refused() {
    let (sandbox, server) = server();
    let (port, token) = (server.port, &server.token);
    let with_host =
        |host: &str| server.raw(format!("GET /{token}/ HTTP/1.1\r\n{host}\r\n").as_bytes()).status;
    assert_eq!(with_host(&format!("Host: 127.0.0.1:{port}\r\n")), 200);
    assert_eq!(with_host(&format!("Host: LocalHost:{port}\r\n")), 200);
    for foreign in ["evil.example", "127.0.0.1", "127.0.0.1.evil.example", "localhost:1"] {
        assert_eq!(with_host(&format!("Host: {foreign}\r\n")), 421, "{foreign}");
    }
    assert_eq!(with_host(&format!("Host: evil.example:{port}\r\n")), 421);
    assert_eq!(with_host(""), 400);
    assert_eq!(with_host(&format!("Host: 127.0.0.1:{port}\r\nHost: evil.example\r\n")), 400);

    let save = json!({ "text": "1", "revision": 1 });
    for origin in ["http://evil.example", "null", "https://127.0.0.1", "http://127.0.0.1:1"] {
        let headers = format!("Origin: {origin}\r\n");
        assert_eq!(server.post_from("save", &save, &headers).status, 403, "{origin}");
    }
    // What a form of another page can send without being asked.
    let body = save.to_string();
    for kind in ["text/plain", "application/x-www-form-urlencoded", ""] {
        let length = body.len();
        let headers = format!("Content-Type: {kind}\r\nContent-Length: {length}\r\n");
        let request = server.head("POST", "save", &headers) + &body;
        assert_eq!(server.raw(request.as_bytes()).status, 403, "{kind}");
    }
    assert_eq!(sandbox.read("s.gml"), ball("a.ppm").as_bytes());
    let ours = format!("Origin: http://127.0.0.1:{port}\r\n");
    assert_eq!(server.post_from("save", &save, &ours).status, 200);
    assert_eq!(sandbox.read("s.gml"), b"1");
}

#[test]
fn only_this_machine_is_listened_to() {
    let (_sandbox, server) = server();
    // All of 127.0.0.0/8 is this machine, but only one address of it is listened at; a server that
    // listens everywhere would be found here.
    assert!(TcpStream::connect(("127.0.0.1", server.port)).is_ok());
    assert!(TcpStream::connect(("127.0.0.2", server.port)).is_err());
}

#[test]
fn what_is_no_request_gets_an_error() {
    let (_sandbox, server) = server();
    let head = |headers: &str| server.head("POST", "run", headers).into_bytes();
    let json = "Content-Type: application/json\r\n";
    let cases: Vec<(&str, Vec<u8>, u16)> = vec![
        ("noise", b"\x16\x03\x01\x02\x00\x01\x00\r\n\r\n".to_vec(), 400),
        ("no version", b"GET /\r\n\r\n".to_vec(), 400),
        ("another method", server.head("PUT", "run", "").into_bytes(), 405),
        ("another method of the page", server.head("DELETE", "", "").into_bytes(), 405),
        ("nothing there", server.head("POST", "none", json).into_bytes(), 404),
        ("a long line", server.head("GET", &"x".repeat(20_000), "").into_bytes(), 431),
        ("many headers", server.head("GET", "", &"a: b\r\n".repeat(100)).into_bytes(), 431),
        (
            "large headers",
            server.head("GET", "", &format!("a: {}\r\n", "b".repeat(20_000))).into(),
            431,
        ),
        ("no text", server.head("GET", "", "a: \u{1}\r\n").into_bytes(), 400),
        ("no length", head(&format!("{json}Content-Length: many\r\n")), 400),
        ("a negative length", head(&format!("{json}Content-Length: -1\r\n")), 400),
        ("two lengths", head(&format!("{json}Content-Length: 1\r\nContent-Length: 2\r\n")), 400),
        ("a huge length", head(&format!("{json}Content-Length: 99999999999999999999999\r\n")), 413),
        ("a large length", head(&format!("{json}Content-Length: 8388609\r\n")), 413),
        ("chunks", head(&format!("{json}Transfer-Encoding: chunked\r\n")), 501),
        ("no body", head(json), 400),
        ("no JSON", [head(&format!("{json}Content-Length: 1\r\n")), b"{".to_vec()].concat(), 400),
    ];
    for (name, request, status) in cases {
        assert_eq!(server.raw(&request).status, status, "{name}");
    }
    let bad = |choice: serde_json::Value| {
        server.post("run", &json!({ "text": "1", "choice": choice })).status
    };
    assert_eq!(bad(json!({ "engine": "x", "precision": "f64", "sampling": "centre" })), 400);
    assert_eq!(bad(json!({ "engine": "jit", "precision": "f64", "sampling": "grid 65" })), 400);
    assert_eq!(bad(json!({ "engine": "jit" })), 400);
    let mut more = choice();
    more["--out-dir"] = json!("/");
    assert_eq!(bad(more), 400);
    // Deep nesting ends the parser, and nothing else.
    let deep = format!("{{\"text\":{}", "[".repeat(1_000_000));
    let length = deep.len();
    let request =
        server.head("POST", "run", &format!("{json}Content-Length: {length}\r\n")) + &deep;
    assert_eq!(server.raw(request.as_bytes()).status, 400);
    // A large body that is announced as such is not read.
    let mut stream = server.connect();
    stream.write_all(&head(&format!("{json}Content-Length: 1000000000\r\n"))).expect("sent");
    assert_eq!(answer(&mut stream).status, 413);
    assert_eq!(server.get("").status, 200);
}

#[test]
fn slow_and_many_clients_do_not_keep_others_out() {
    let (_sandbox, server) = server();
    let begun = Instant::now();
    let mut idle: Vec<TcpStream> = (0..MAX_CONNECTIONS + 4).map(|_| server.connect()).collect();
    idle[0].write_all(b"GET / HT").expect("sent");
    // There is room for so many; the next is told so at once.
    let refused = server.get("");
    assert_eq!(refused.status, 503);
    assert!(begun.elapsed() < HEAD_TIME, "{:?}", begun.elapsed());
    assert_eq!(answer(&mut idle[0]).status, 408);
    assert!(begun.elapsed() >= HEAD_TIME);
    let begun = Instant::now();
    while server.get("").status == 503 {
        assert!(begun.elapsed() < 4 * HEAD_TIME, "still no room");
        // Those who are refused have a place too, until their threads have ended.
        std::thread::sleep(Duration::from_millis(20));
    }
    // A body that does not come.
    let headers = "Content-Type: application/json\r\nContent-Length: 100\r\n";
    let mut half = server.connect();
    half.write_all((server.head("POST", "run", headers) + "{").as_bytes()).expect("sent");
    half.shutdown(std::net::Shutdown::Write).expect("shut");
    assert_eq!(answer(&mut half).status, 400);
    assert_eq!(server.get("").status, 200);
}
