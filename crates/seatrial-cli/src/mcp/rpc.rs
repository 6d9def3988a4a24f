//! Messages of JSON-RPC 2.0.

use serde_json::{Value, json};

/// A request, or a notification where it has no id.
pub struct Request {
    /// A string or a number.
    pub id: Option<Value>,
    /// What is asked.
    pub method: String,
    /// With what; an object.
    pub params: Value,
}

/// Why a message has no result.
#[derive(Debug)]
pub struct Fault {
    code: i32,
    message: String,
}

impl Fault {
    /// A message that is no JSON.
    fn parse(message: String) -> Self {
        Self { code: -32700, message }
    }

    /// JSON that is no request.
    pub fn request(message: &str) -> Self {
        Self { code: -32600, message: message.into() }
    }

    /// A method that there is not.
    pub fn method(name: &str) -> Self {
        Self {
            code: -32601,
            message: format!(
                "no method {name:?}; there are initialize, ping, tools/list and tools/call"
            ),
        }
    }

    /// Parameters that do not fit.
    pub fn params(message: impl std::fmt::Display) -> Self {
        Self { code: -32602, message: message.to_string() }
    }

    /// As the answer to the message with this id.
    pub fn answer(&self, id: &Value) -> Value {
        let error = json!({"code": self.code, "message": self.message});
        json!({"jsonrpc": "2.0", "id": id, "error": error})
    }
}

impl Request {
    /// Reads a message; else its id, null where it is not known, and what is wrong.
    pub fn read(line: &[u8]) -> Result<Self, (Value, Fault)> {
        let message: Value = serde_json::from_slice(line)
            .map_err(|error| (Value::Null, Fault::parse(format!("no JSON: {error}"))))?;
        let Value::Object(mut fields) = message else {
            let fault = Fault::request("expected one object with a method; batches are not taken");
            return Err((Value::Null, fault));
        };
        let id = match fields.remove("id") {
            None => None,
            Some(id @ (Value::String(_) | Value::Number(_))) => Some(id),
            Some(_) => {
                let fault = Fault::request("id: expected a string or a number");
                return Err((Value::Null, fault));
            }
        };
        let refused = |message: &str| {
            let known = id.clone().unwrap_or(Value::Null);
            (known, Fault::request(message))
        };
        if fields.get("jsonrpc").and_then(Value::as_str) != Some("2.0") {
            return Err(refused("jsonrpc: expected \"2.0\""));
        }
        let Some(Value::String(method)) = fields.remove("method") else {
            return Err(refused("method: expected a string"));
        };
        let params = match fields.remove("params") {
            None => json!({}),
            Some(params @ Value::Object(_)) => params,
            Some(_) => return Err(refused("params: expected an object")),
        };
        Ok(Self { id, method, params })
    }
}
