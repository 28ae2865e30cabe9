//! The README of a case as HTML. Links lose their targets and pictures go, as the page stands alone.

use pulldown_cmark::{Event, HeadingLevel, Options, Parser, Tag, TagEnd, html::push_html};

/// The first paragraph, and everything after it; the title is left out.
pub(super) fn halves(text: &str) -> (String, String) {
    let options = Options::ENABLE_TABLES | Options::ENABLE_STRIKETHROUGH;
    let (mut in_title, mut in_picture) = (false, false);
    let events = Parser::new_ext(text, options).filter(|event| {
        match event {
            Event::Start(Tag::Heading { level, .. }) if *level as u8 == 1 => in_title = true,
            Event::Start(Tag::Image { .. }) => in_picture = true,
            Event::End(TagEnd::Image) => {
                in_picture = false;
                return false;
            }
            Event::End(TagEnd::Heading(level)) if *level as u8 == 1 => {
                in_title = false;
                return false;
            }
            // Raw HTML goes as well: nobody would check it.
            Event::Start(Tag::Link { .. })
            | Event::End(TagEnd::Link)
            | Event::Html(_)
            | Event::InlineHtml(_) => return false,
            _ => {}
        }
        !in_title && !in_picture
    });
    // Headings rank below that of the case.
    let events = events.map(|event| match event {
        Event::Start(Tag::Heading { level: _, id, classes, attrs }) => {
            Event::Start(Tag::Heading { level: HeadingLevel::H3, id, classes, attrs })
        }
        Event::End(TagEnd::Heading(_)) => Event::End(TagEnd::Heading(HeadingLevel::H3)),
        other => other,
    });
    let (mut lead, mut rest) = (Vec::new(), Vec::new());
    let mut first = true;
    for event in events {
        let ends = event == Event::End(TagEnd::Paragraph);
        if first { &mut lead } else { &mut rest }.push(event);
        first &= !ends;
    }
    let html = |events: Vec<Event<'_>>| {
        let mut html = String::new();
        push_html(&mut html, events.into_iter());
        html
    };
    (html(lead), html(rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_paragraph_stands_alone_without_title_links_and_pictures() {
        let (lead, rest) = halves(
            "# Title\n\nFirst [link](x.md) of *all*.\n\n## More\n\n![a picture](p.png)\n\n| a | b |\n|---|---|\n| 1 | <b>2</b> |\n",
        );
        assert_eq!(lead.trim(), "<p>First link of <em>all</em>.</p>");
        assert!(
            rest.contains("<table>")
                && rest.contains("<h3>More</h3>")
                && !rest.contains("p.png")
                && !rest.contains("<b>"),
            "{rest}"
        );
        assert!(!rest.contains("a picture"));
    }
}
