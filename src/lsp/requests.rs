//! Requests by their methods: parameters in, results out.

use std::collections::HashMap;
use std::sync::Arc;

use lsp_types::request::{
    CodeActionRequest, Completion, DocumentHighlightRequest, DocumentSymbolRequest, GotoDefinition,
    HoverRequest, PrepareRenameRequest, References, Rename, Request,
};
use lsp_types::{
    CodeAction, CodeActionKind, CodeActionOrCommand, CodeActionParams,
    CodeActionProviderCapability, CompletionOptions, CompletionResponse, DocumentSymbolResponse,
    GotoDefinitionResponse, HoverProviderCapability, InitializeResult, OneOf, RenameOptions,
    SaveOptions, ServerCapabilities, ServerInfo, TextDocumentPositionParams,
    TextDocumentSyncCapability, TextDocumentSyncKind, TextDocumentSyncOptions,
    TextDocumentSyncSaveOptions, TextEdit, Uri, WorkspaceEdit,
};
use serde_json::Value;

use crate::lsp::message::{ErrorCode, ResponseError};
use crate::lsp::program::Program;
use crate::lsp::{Server, answers};

type Answer = Result<Value, ResponseError>;

/// What the server can do.
pub(super) fn capabilities() -> Answer {
    let sync = TextDocumentSyncOptions {
        open_close: Some(true),
        change: Some(TextDocumentSyncKind::INCREMENTAL),
        save: Some(TextDocumentSyncSaveOptions::SaveOptions(SaveOptions::default())),
        ..TextDocumentSyncOptions::default()
    };
    let rename = RenameOptions {
        prepare_provider: Some(true),
        work_done_progress_options: Default::default(),
    };
    let capabilities = ServerCapabilities {
        text_document_sync: Some(TextDocumentSyncCapability::Options(sync)),
        hover_provider: Some(HoverProviderCapability::Simple(true)),
        definition_provider: Some(OneOf::Left(true)),
        references_provider: Some(OneOf::Left(true)),
        document_highlight_provider: Some(OneOf::Left(true)),
        document_symbol_provider: Some(OneOf::Left(true)),
        completion_provider: Some(CompletionOptions::default()),
        rename_provider: Some(OneOf::Right(rename)),
        code_action_provider: Some(CodeActionProviderCapability::Simple(true)),
        ..ServerCapabilities::default()
    };
    let server_info = Some(ServerInfo {
        name: env!("CARGO_PKG_NAME").to_owned(),
        version: Some(env!("CARGO_PKG_VERSION").to_owned()),
    });
    value(InitializeResult { capabilities, server_info })
}

impl Server {
    /// Answers a request.
    pub(super) fn request(&mut self, method: &str, params: Value) -> Answer {
        match method {
            HoverRequest::METHOD => {
                let params = typed::<HoverRequest>(params)?.text_document_position_params;
                self.at(&params, |program, at| answers::hover(program, at.position))
            }
            GotoDefinition::METHOD => {
                let params = typed::<GotoDefinition>(params)?.text_document_position_params;
                let open = Arc::clone(&self.open);
                self.at(&params, |program, at| {
                    let place = answers::definition(program, at.position, &open);
                    place.map(GotoDefinitionResponse::Scalar)
                })
            }
            References::METHOD => {
                let params = typed::<References>(params)?;
                let open = Arc::clone(&self.open);
                let with_binder = params.context.include_declaration;
                self.at(&params.text_document_position, |program, at| {
                    answers::references(program, at.position, with_binder, &open)
                })
            }
            DocumentHighlightRequest::METHOD => {
                let params = typed::<DocumentHighlightRequest>(params)?;
                self.at(&params.text_document_position_params, |program, at| {
                    answers::highlights(program, at.position)
                })
            }
            PrepareRenameRequest::METHOD => self
                .at(&typed::<PrepareRenameRequest>(params)?, |program, at| {
                    answers::prepare_rename(program, at.position)
                }),
            Completion::METHOD => {
                let params = typed::<Completion>(params)?.text_document_position;
                self.at(&params, |program, at| {
                    Some(CompletionResponse::Array(answers::completions(program, at.position)))
                })
            }
            DocumentSymbolRequest::METHOD => {
                let uri = typed::<DocumentSymbolRequest>(params)?.text_document.uri;
                let program = self.program(&uri);
                value(program.map(|p| DocumentSymbolResponse::Nested(answers::symbols(&p))))
            }
            Rename::METHOD => self.rename(&typed::<Rename>(params)?),
            CodeActionRequest::METHOD => value(corrections(typed::<CodeActionRequest>(params)?)),
            _ => Err(ResponseError::new(
                ErrorCode::MethodNotFound,
                format!("`{method}` is not known"),
            )),
        }
    }

    /// Answers a request about a place, with null where there is no such document.
    fn at<T: serde::Serialize>(
        &mut self,
        at: &TextDocumentPositionParams,
        find: impl FnOnce(&Program, &TextDocumentPositionParams) -> Option<T>,
    ) -> Answer {
        let program = self.program(&at.text_document.uri);
        value(program.and_then(|program| find(&program, at)))
    }

    fn rename(&mut self, params: &lsp_types::RenameParams) -> Answer {
        let at = &params.text_document_position;
        let uri = &at.text_document.uri;
        let program = self.program(uri);
        let found = program.ok_or_else(|| "no such document is open".to_owned());
        let edits =
            found.and_then(|program| answers::rename(&program, at.position, &params.new_name));
        match edits {
            Ok(edits) => value(changes(uri, edits)),
            Err(reason) => Err(ResponseError::new(ErrorCode::RequestFailed, reason)),
        }
    }
}

fn changes(uri: &Uri, edits: Vec<TextEdit>) -> WorkspaceEdit {
    #[expect(clippy::mutable_key_type, reason = "the protocol's type, and no URI is changed")]
    let changes = HashMap::from([(uri.clone(), edits)]);
    WorkspaceEdit { changes: Some(changes), ..WorkspaceEdit::default() }
}

/// For each name that is not bound, the bound one that may be meant.
fn corrections(params: CodeActionParams) -> Vec<CodeActionOrCommand> {
    let uri = params.text_document.uri;
    let correction = |found: lsp_types::Diagnostic| {
        let name = found.data.as_ref()?.get("replacement")?.as_str()?.to_owned();
        let edit = TextEdit { range: found.range, new_text: name.clone() };
        Some(CodeActionOrCommand::CodeAction(CodeAction {
            title: format!("Change to `{name}`"),
            kind: Some(CodeActionKind::QUICKFIX),
            edit: Some(changes(&uri, vec![edit])),
            diagnostics: Some(vec![found]),
            ..CodeAction::default()
        }))
    };
    params.context.diagnostics.into_iter().filter_map(correction).collect()
}

fn typed<R: Request>(params: Value) -> Result<R::Params, ResponseError> {
    serde_json::from_value(params).map_err(|e| ResponseError::new(ErrorCode::InvalidParams, e))
}

fn value(result: impl serde::Serialize) -> Answer {
    serde_json::to_value(result).map_err(|e| ResponseError::new(ErrorCode::InternalError, e))
}
