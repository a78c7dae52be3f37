#include "io/plot/html_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string_view>

#include "io/plot/markup.h"

namespace meander {

namespace {

constexpr std::string_view style = R"(
:root { color-scheme: light dark; --paper: #ffffff; --ink: #1d1f22; --quiet: #5d636b; --line: #d9dce0;
  --link: #0b5cad; }
@media (prefers-color-scheme: dark) {
  :root { --paper: #17191c; --ink: #e4e6e9; --quiet: #a2a8b0; --line: #3a3e44; --link: #7db8f0; }
}
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink); font: 16px/1.55 system-ui, sans-serif; }
main { max-width: 68rem; margin: 0 auto; padding: 2rem 1.25rem 4rem; }
h1 { font-size: 1.8rem; line-height: 1.2; margin: 0 0 1rem; }
h2 { font-size: 1.25rem; margin: 0 0 1rem; }
p { max-width: 46rem; margin: 0.6rem 0; }
a { color: var(--link); }
nav ol { padding-left: 1.4rem; columns: 20rem; column-gap: 2.5rem; }
nav li { break-inside: avoid; line-height: 1.3; padding: 0.2em 0; }
section { border-top: 1px solid var(--line); padding-top: 1.75rem; margin-top: 2.5rem; }
.images { display: flex; flex-wrap: wrap; gap: 1rem; align-items: flex-start; }
figure { margin: 0; max-width: 100%; }
figure svg { display: block; max-width: 100%; height: auto; border-radius: 4px; }
figure img { display: block; max-width: 100%; height: auto; background: #ffffff;
  border: 1px solid var(--line); border-radius: 4px; }
figcaption { color: var(--quiet); font-size: 0.9rem; margin-top: 0.35rem; }
.table { overflow-x: auto; margin: 1rem 0; }
sup, sub { line-height: 0; }
table { border-collapse: collapse; font-size: 0.92rem; font-variant-numeric: tabular-nums; }
caption { text-align: left; color: var(--quiet); padding-bottom: 0.4rem; }
th, td { padding: 0.28rem 0.9rem 0.28rem 0; text-align: left; border-bottom: 1px solid var(--line);
  white-space: nowrap; }
th.number, td.number { text-align: right; }
footer, .data { color: var(--quiet); font-size: 0.9rem; }
footer { border-top: 1px solid var(--line); margin-top: 3rem; padding-top: 1rem; }
)";

// A relative file name as a link target.
std::string link_to(std::string_view file) {
  const std::size_t colon = file.find(':');
  if (file.empty() || file.front() == '/' || (colon != std::string_view::npos && colon < file.find('/')))
    throw std::invalid_argument("html_page: \"" + std::string(file) + "\" is no relative file name");
  std::string out;
  for (const char c : file) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("-._~/").find(c) != std::string_view::npos;
    out += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return out;
}

// The text escaped, with raised and lowered runs.
std::string marked_up(std::string_view text) {
  std::string out;
  for (const TextRun& run : text_runs(text)) {
    const std::string inner = escape_markup(run.text);
    out += run.shift == 0 ? inner : fmt::format("<{0}>{1}</{0}>", run.shift < 0 ? "sup" : "sub", inner);
  }
  return out;
}

std::string paragraph(const PageParagraph& content) {
  std::string label;
  if (!content.label.empty()) label = "<strong>" + marked_up(content.label) + "</strong> ";
  return "<p>" + label + marked_up(content.text) + "</p>\n";
}

// The SVG without its XML declaration.
std::string_view svg_element(std::string_view svg) {
  return svg.substr(std::min(svg.find("<svg"), svg.size()));
}

std::string image(const PageImage& content) {
  if (!content.svg.empty()) {
    const std::string caption =
        content.caption.empty() ? "" : "<figcaption>" + marked_up(content.caption) + "</figcaption>";
    return fmt::format("<figure role=\"img\" aria-label=\"{}\">{}{}</figure>\n", escape_markup(content.text),
                       svg_element(content.svg), caption);
  }
  std::string out = fmt::format("<figure><a href=\"{0}\"><img src=\"{0}\" alt=\"{1}\" loading=\"lazy\"/></a>",
                                link_to(content.file), escape_markup(content.text));
  if (!content.caption.empty()) out += "<figcaption>" + marked_up(content.caption) + "</figcaption>";
  return out + "</figure>\n";
}

std::string table(const PageTable& content) {
  const Table& values = content.table;
  check_table(values);
  if (values.columns.empty()) return {};
  const auto cell = [&](std::string_view tag, std::size_t column, const std::string& text) {
    return fmt::format("<{0}{1}>{2}</{0}>", tag, is_numeric_column(values, column) ? " class=\"number\"" : "",
                       content.plain ? escape_markup(text) : marked_up(text));
  };
  std::string out = "<div class=\"table\"><table>\n";
  if (!content.caption.empty()) out += "<caption>" + marked_up(content.caption) + "</caption>\n";
  out += "<thead><tr>";
  for (std::size_t c = 0; c < values.columns.size(); ++c) out += cell("th", c, values.columns[c].name);
  out += "</tr></thead>\n<tbody>\n";
  for (const auto& row : values.rows) {
    out += "<tr>";
    for (std::size_t c = 0; c < values.columns.size(); ++c)
      out += cell("td", c, c < row.size() ? readable_cell(row[c], values.columns[c].digits) : "");
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

std::string data_links(const std::vector<std::string>& files) {
  if (files.empty()) return {};
  std::string out = "<p class=\"data\">Data:";
  for (const std::string& file : files)
    out += fmt::format("{} <a href=\"{}\">{}</a>", &file == files.data() ? "" : ",", link_to(file),
                       escape_markup(file));
  return out + "</p>\n";
}

std::string section(const PageFigure& figure, std::size_t position) {
  std::string out =
      fmt::format("<section id=\"figure-{}\">\n<h2>{}</h2>\n", position, marked_up(figure.heading));
  if (!figure.images.empty()) {
    out += "<div class=\"images\">\n";
    for (const PageImage& content : figure.images) out += image(content);
    out += "</div>\n";
  }
  for (const PageParagraph& content : figure.paragraphs) out += paragraph(content);
  for (const PageTable& content : figure.tables) out += table(content);
  return out + data_links(figure.data) + "</section>\n";
}

}  // namespace

std::string html_page(const FigurePage& page) {
  std::string out = fmt::format(
      "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\">\n<head>\n<meta "
      "charset=\"utf-8\"/>\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      "<title>{0}</title>\n<style>{1}</style>\n</head>\n<body>\n<main>\n<h1>{0}</h1>\n",
      escape_markup(page.title), style);
  for (const PageParagraph& content : page.introduction) out += paragraph(content);
  if (page.figures.size() > 1) {
    out += "<nav><ol>\n";
    for (std::size_t i = 0; i < page.figures.size(); ++i)
      out +=
          fmt::format("<li><a href=\"#figure-{}\">{}</a></li>\n", i + 1, marked_up(page.figures[i].heading));
    out += "</ol></nav>\n";
  }
  for (std::size_t i = 0; i < page.figures.size(); ++i) out += section(page.figures[i], i + 1);
  if (!page.footer.empty()) out += "<footer>" + marked_up(page.footer) + "</footer>\n";
  return out + "</main>\n</body>\n</html>\n";
}

}  // namespace meander
