#include "io/plot/markup.h"

#include <algorithm>

#include "io/utf8.h"

namespace meander {

namespace {

constexpr std::string_view replacement = "\xEF\xBF\xBD";

// The escaped form of one character; `bytes` is a well-formed sequence.
std::string_view escaped(std::string_view bytes) {
  switch (bytes[0]) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    case '\'':
      return "&#39;";
    default:
      break;
  }
  const unsigned char lead = static_cast<unsigned char>(bytes[0]);
  if (lead < 0x20 && lead != '\t' && lead != '\n' && lead != '\r') return replacement;
  if (bytes == "\xEF\xBF\xBE" || bytes == "\xEF\xBF\xBF") return replacement;
  return bytes;
}

}  // namespace

std::string escape_markup(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = utf8_sequence_length(text);
    out += length == 0 ? replacement : escaped(text.substr(0, length));
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return out;
}

std::vector<TextRun> text_runs(std::string_view text) {
  std::vector<TextRun> runs;
  while (!text.empty()) {
    const std::size_t mark = std::min({text.find("^{"), text.find("_{"), text.size()});
    const std::size_t end = mark < text.size() ? text.find('}', mark) : std::string_view::npos;
    if (end == std::string_view::npos) {
      runs.push_back({text, 0});
      break;
    }
    if (mark > 0) runs.push_back({text.substr(0, mark), 0});
    runs.push_back({text.substr(mark + 2, end - mark - 2), text[mark] == '^' ? -1 : 1});
    text.remove_prefix(end + 1);
  }
  return runs;
}

}  // namespace meander
