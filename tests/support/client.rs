//! An editor, as far as `gmlvm lsp` can tell.

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::Duration;

use serde_json::{Value, json};

/// Longer than anything takes that is asked for here, on a busy machine too.
const PATIENCE: Duration = Duration::from_secs(60);

/// A server, and what it has said that nobody has looked at yet.
pub(crate) struct Client {
    child: Child,
    input: Option<ChildStdin>,
    output: Receiver<Value>,
    unread: VecDeque<Value>,
    n_requests: i64,
}

impl Client {
    /// Starts a server with these options, not initialized.
    pub(crate) fn start(args: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gmlvm"));
        command.arg("lsp").args(args).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.stderr(Stdio::piped()).spawn().expect("the binary runs");
        let stdout = child.stdout.take().expect("piped");
        let (sender, output) = mpsc::channel();
        thread::spawn(move || {
            let mut stream = BufReader::new(stdout);
            while let Some(message) = read(&mut stream) {
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        let input = child.stdin.take();
        Client { child, input, output, unread: VecDeque::new(), n_requests: 0 }
    }

    /// The same, initialized.
    pub(crate) fn new(args: &[&str]) -> Self {
        let mut client = Client::start(args);
        let answer = client.request("initialize", json!({ "capabilities": {} }));
        assert_eq!(answer["capabilities"]["textDocumentSync"]["change"], 2);
        client.notify("initialized", json!({}));
        client
    }

    /// Sends bytes as they are. The server may have gone, which shows elsewhere.
    pub(crate) fn send_bytes(&mut self, bytes: &[u8]) {
        let input = self.input.as_mut().expect("not closed");
        let _ = input.write_all(bytes).and_then(|()| input.flush());
    }

    pub(crate) fn send(&mut self, message: &Value) {
        let text = message.to_string();
        self.send_bytes(format!("Content-Length: {}\r\n\r\n{text}", text.len()).as_bytes());
    }

    pub(crate) fn notify(&mut self, method: &str, params: Value) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    /// The result of a request, or its error as `CODE: MESSAGE`.
    pub(crate) fn try_request(&mut self, method: &str, params: Value) -> Result<Value, String> {
        self.n_requests += 1;
        let id = self.n_requests;
        self.send(&json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params }));
        let answer = self.wait(|message| message["id"] == id);
        match answer.get("error") {
            None => Ok(answer["result"].clone()),
            Some(error) => {
                Err(format!("{}: {}", error["code"], error["message"].as_str().expect("text")))
            }
        }
    }

    pub(crate) fn request(&mut self, method: &str, params: Value) -> Value {
        self.try_request(method, params).expect("an answer")
    }

    /// The first message of a kind, those that are set aside included.
    pub(crate) fn wait(&mut self, is_it: impl Fn(&Value) -> bool) -> Value {
        if let Some(idx) = self.unread.iter().position(&is_it) {
            return self.unread.remove(idx).expect("just found");
        }
        loop {
            let message = self.output.recv_timeout(PATIENCE).expect("the server says something");
            if is_it(&message) {
                return message;
            }
            self.unread.push_back(message);
        }
    }

    pub(crate) fn open(&mut self, uri: &str, text: &str) {
        let item = json!({ "uri": uri, "languageId": "gml", "version": 1, "text": text });
        self.notify("textDocument/didOpen", json!({ "textDocument": item }));
    }

    /// Makes changes to a document, each as the protocol has it.
    pub(crate) fn change(&mut self, uri: &str, version: i64, changes: Value) {
        let document = json!({ "uri": uri, "version": version });
        let params = json!({ "textDocument": document, "contentChanges": changes });
        self.notify("textDocument/didChange", params);
    }

    /// What is wrong with a state of a document, once the server knows.
    pub(crate) fn diagnostics(&mut self, uri: &str, version: i64) -> Vec<Value> {
        let message = self.wait(|message| {
            message["method"] == "textDocument/publishDiagnostics"
                && message["params"]["uri"] == uri
                && message["params"]["version"] == version
        });
        message["params"]["diagnostics"].as_array().expect("a list").clone()
    }

    /// Says goodbye; returns the exit code.
    pub(crate) fn quit(mut self) -> i32 {
        self.request("shutdown", Value::Null);
        self.notify("exit", Value::Null);
        self.code().0
    }

    /// Waits for the server's end, without closing its input; the exit code and what it says.
    pub(crate) fn code(mut self) -> (i32, String) {
        let status = self.child.wait().expect("it ends");
        let mut stderr = String::new();
        let mut stream = self.child.stderr.take().expect("piped");
        stream.read_to_string(&mut stderr).expect("text");
        (status.code().unwrap_or(-1), stderr)
    }

    /// Goes away without a word.
    pub(crate) fn hang_up(mut self) -> (i32, String) {
        self.input = None;
        self.code()
    }
}

fn read(stream: &mut impl BufRead) -> Option<Value> {
    let mut length = 0;
    loop {
        let mut line = String::new();
        stream.read_line(&mut line).ok().filter(|n| *n > 0)?;
        if line == "\r\n" {
            break;
        }
        length = line.trim_end().strip_prefix("Content-Length: ")?.parse().ok()?;
    }
    let mut body = vec![0; length];
    stream.read_exact(&mut body).ok()?;
    serde_json::from_slice(&body).ok()
}
