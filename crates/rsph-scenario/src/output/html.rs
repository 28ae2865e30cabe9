//! Pages in HTML: escaped text, filled templates.

/// `text` as HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The template with every `{{name}}` replaced by `value(name)`, in one pass: what is put in is
/// not searched again.
pub fn fill(template: &str, value: &dyn Fn(&str) -> String) -> String {
    let mut out = String::new();
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        out.push_str(before);
        out.push_str(&value(name));
        rest = after;
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filling_is_one_pass() {
        let page = fill("a {{x}} b {{y}} c", &|name| format!("<{name} {{{{x}}}}>"));
        assert_eq!(page, "a <x {{x}}> b <y {{x}}> c");
    }
}
