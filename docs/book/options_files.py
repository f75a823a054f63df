"""Colours for options files in the book: comments, names of options, and their values."""

from pygments.lexer import RegexLexer
from pygments.token import Comment, Name, Number, Text


class OptionsLexer(RegexLexer):
    """One -name value a line; # begins a comment."""
    name = "mlgimp options"
    tokens = {"root": [(r"#.*$", Comment), (r"^-[A-Za-z]\w*", Name.Tag), (r"[-+]?\d[\w.+-]*", Number),
                       (r"[A-Za-z]\w*|\s|[^\s#]", Text)]}


def setup(app):
    """Makes `opts` the language of options files."""
    app.add_lexer("opts", OptionsLexer)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
