//! Messages of JSON-RPC: what a client says, and what it is told.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// What a client says.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum Message {
    /// What wants an answer.
    Request(Request),
    /// An answer to what we have asked, which is nothing.
    Response {
        #[serde(rename = "id")]
        _id: Id,
        #[serde(rename = "result", alias = "error")]
        _result: Value,
    },
    /// What has none.
    Notification(Notification),
}

/// By which an answer is known.
#[derive(Debug, Serialize, Deserialize)]
#[serde(untagged)]
pub(super) enum Id {
    Number(i32),
    Text(String),
}

#[derive(Debug, Deserialize)]
pub(super) struct Request {
    pub(super) id: Id,
    pub(super) method: String,
    #[serde(default)]
    pub(super) params: Value,
}

#[derive(Debug, Deserialize)]
pub(super) struct Notification {
    pub(super) method: String,
    #[serde(default)]
    pub(super) params: Value,
}

/// Why there is no result; the numbers are those of JSON-RPC and of the protocol.
#[derive(Clone, Copy, Debug)]
pub(super) enum ErrorCode {
    ParseError = -32700,
    InvalidRequest = -32600,
    MethodNotFound = -32601,
    InvalidParams = -32602,
    InternalError = -32603,
    ServerNotInitialized = -32002,
    RequestFailed = -32803,
}

/// An answer that is no result.
#[derive(Debug, Serialize)]
pub(super) struct ResponseError {
    code: i32,
    message: String,
}

impl ResponseError {
    pub(super) fn new(code: ErrorCode, message: impl ToString) -> Self {
        ResponseError { code: code as i32, message: message.to_string() }
    }
}

/// The answer to a request.
pub(super) fn response(id: &impl Serialize, result: &Result<Value, ResponseError>) -> Value {
    match result {
        Ok(result) => json!({ "jsonrpc": "2.0", "id": id, "result": result }),
        Err(error) => json!({ "jsonrpc": "2.0", "id": id, "error": error }),
    }
}

/// A notification for the client.
pub(super) fn notification(method: &str, params: &impl Serialize) -> Value {
    json!({ "jsonrpc": "2.0", "method": method, "params": params })
}
