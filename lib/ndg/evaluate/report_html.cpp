// SPDX-License-Identifier: Apache-2.0
#include "ndg/evaluate/report_html.h"

#include "ndg/core/markup.h"

#include <algorithm>
#include <cstdint>

namespace ndg {
namespace {

/// RFC 4648.
std::string base64(const std::string& bytes)
{
    static const char* const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t group = 0;
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
        for (std::size_t k = 0; k < 3; ++k)
            group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k) text += k <= count ? letters[group >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

const char* const page_style = R"(
:root { color-scheme: light dark; --fg: #1d2228; --bg: #fbfbfa; --line: #cfd4da; --soft: #5c6670; }
@media (prefers-color-scheme: dark) { :root { --fg: #e4e7ea; --bg: #17191c; --line: #3a4047; --soft: #9aa4ae; } }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--fg); background: var(--bg); max-width: 76rem; margin: 2rem auto;
  padding: 0 1rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: 1rem 0; font-variant-numeric: tabular-nums; font-size: 0.92rem; }
th, td { border-bottom: 1px solid var(--line); padding: 0.3rem 0.8rem; text-align: right; vertical-align: top; }
th:first-child, td:first-child { text-align: left; white-space: nowrap; }
td:last-child { overflow-wrap: anywhere; }
figure { margin: 2rem 0; } img, svg { max-width: 100%; height: auto; border-radius: 6px; }
svg { width: 52rem; } svg text { font-size: 12px; fill: currentColor; }
.grid { stroke: var(--line); } .line { fill: none; stroke-width: 1.8; }
figcaption, .note { color: var(--soft); max-width: 60rem; }
)";

}  // namespace

std::string html_table(const std::vector<std::vector<std::string>>& table)
{
    std::string text = "<div class=\"wide\"><table>\n";
    for (std::size_t i = 0; i < table.size(); ++i) {
        text += "<tr>";
        for (const std::string& cell : table[i])
            text += i == 0 ? "<th>" + escaped_markup(cell) + "</th>" : "<td>" + escaped_markup(cell) + "</td>";
        text += "</tr>\n";
    }
    return text + "</table></div>\n";
}

std::string html_picture(const std::string& png, const std::string& name)
{
    return "<img src=\"data:image/png;base64," + base64(png) + "\" alt=\"" + escaped_markup(name) + "\">";
}

std::string html_figure(const std::string& content, const std::string& caption)
{
    if (content.empty()) return "";
    return "<figure>" + content + "<figcaption>" + escaped_markup(caption) + "</figcaption></figure>\n";
}

std::string html_report(const std::string& title, const std::string& body)
{
    return "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
           "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
           "<title>" +
           escaped_markup(title) + "</title>\n<style>" + std::string(page_style) + "</style>\n</head>\n<body>\n<h1>" +
           escaped_markup(title) + "</h1>\n" + body + "</body>\n</html>\n";
}

}  // namespace ndg
