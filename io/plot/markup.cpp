#include "io/plot/markup.h"

#include "io/utf8.h"

namespace meander {

namespace {

constexpr std::string_view replacement = "\xEF\xBF\xBD";

// What stands for one character; `bytes` is a well-formed sequence.
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

}  // namespace meander
