//! Requests by their methods: parameters in, results out.

use std::sync::Arc;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::lsp::message::{ErrorCode, ResponseError};
use crate::lsp::program::Program;
use crate::lsp::types::{
    CodeActionParams, DocumentParams, Position, PositionParams, Range, ReferenceParams,
    RenameParams, TextEdit,
};
use crate::lsp::{Server, answers};

type Answer = Result<Value, ResponseError>;

/// Texts are sent by their changes.
const INCREMENTAL: u8 = 2;

/// What the server can do.
pub(super) fn capabilities() -> Value {
    json!({
        "capabilities": {
            "textDocumentSync": { "openClose": true, "change": INCREMENTAL, "save": {} },
            "hoverProvider": true,
            "definitionProvider": true,
            "referencesProvider": true,
            "documentHighlightProvider": true,
            "documentSymbolProvider": true,
            "completionProvider": {},
            "renameProvider": { "prepareProvider": true },
            "codeActionProvider": true,
        },
        "serverInfo": {
            "name": env!("CARGO_PKG_NAME"),
            "version": env!("CARGO_PKG_VERSION"),
        },
    })
}

impl Server {
    /// Answers a request.
    pub(super) fn request(&mut self, method: &str, params: Value) -> Answer {
        match method {
            "textDocument/hover" => self.at(&typed(params)?, answers::hover),
            "textDocument/definition" => {
                let open = Arc::clone(&self.open);
                self.at(&typed(params)?, |program, place| {
                    answers::definition(program, place, &open)
                })
            }
            "textDocument/references" => {
                let ReferenceParams { at, context } = typed(params)?;
                let open = Arc::clone(&self.open);
                self.at(&at, |program, place| {
                    answers::references(program, place, context.include_declaration, &open)
                })
            }
            "textDocument/documentHighlight" => self.at(&typed(params)?, answers::highlights),
            "textDocument/prepareRename" => self.at(&typed(params)?, answers::prepare_rename),
            "textDocument/completion" => self
                .at(&typed(params)?, |program, place| Some(answers::completions(program, place))),
            "textDocument/documentSymbol" => {
                let params: DocumentParams = typed(params)?;
                value(self.program(&params.text_document.uri).map(|p| answers::symbols(&p)))
            }
            "textDocument/rename" => self.rename(&typed(params)?),
            "textDocument/codeAction" => Ok(corrections(&typed(params)?)),
            _ => Err(ResponseError::new(
                ErrorCode::MethodNotFound,
                format!("`{method}` is not known"),
            )),
        }
    }

    /// Answers a request about a place, with null where there is no such document.
    fn at<T: serde::Serialize>(
        &mut self,
        at: &PositionParams,
        find: impl FnOnce(&Program, Position) -> Option<T>,
    ) -> Answer {
        let program = self.program(&at.text_document.uri);
        value(program.and_then(|program| find(&program, at.position)))
    }

    fn rename(&mut self, params: &RenameParams) -> Answer {
        let at = &params.at;
        let uri = &at.text_document.uri;
        let program = self.program(uri);
        let found = program.ok_or_else(|| "no such document is open".to_owned());
        let edits =
            found.and_then(|program| answers::rename(&program, at.position, &params.new_name));
        match edits {
            Ok(edits) => Ok(changes(uri, &edits)),
            Err(reason) => Err(ResponseError::new(ErrorCode::RequestFailed, reason)),
        }
    }
}

fn changes(uri: &str, edits: &[TextEdit]) -> Value {
    json!({ "changes": { uri: edits } })
}

/// For each name that is not bound, the bound one that may be meant.
fn corrections(params: &CodeActionParams) -> Value {
    let uri = &params.text_document.uri;
    let correction = |found: &Value| {
        let name = found["data"]["replacement"].as_str()?;
        let range = Range::deserialize(&found["range"]).ok()?;
        let edit = TextEdit { range, new_text: name.to_owned() };
        Some(json!({
            "title": format!("Change to `{name}`"),
            "kind": "quickfix",
            "edit": changes(uri, &[edit]),
            "diagnostics": [found],
        }))
    };
    params.context.diagnostics.iter().filter_map(correction).collect()
}

fn typed<P: DeserializeOwned>(params: Value) -> Result<P, ResponseError> {
    serde_json::from_value(params).map_err(|e| ResponseError::new(ErrorCode::InvalidParams, e))
}

fn value(result: impl serde::Serialize) -> Answer {
    serde_json::to_value(result).map_err(|e| ResponseError::new(ErrorCode::InternalError, e))
}
