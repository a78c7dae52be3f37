#include "io/item_id.h"

#include "io/utf8.h"

namespace meander {

namespace {

constexpr int digit_of(char c) {
  return c >= '0' && c <= '9' ? c - '0' : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

// The byte encoded by an escape at the front of `text`, -1 where there is none.
int escaped_byte(std::string_view text) {
  if (text.size() < 3 || text[0] != '%') return -1;
  const int high = digit_of(text[1]), low = digit_of(text[2]);
  if (high < 0 || low < 0) return -1;
  const int byte = 16 * high + low;
  return byte < 0x20 || byte == '%' || byte >= 0x7F ? byte : -1;
}

// Well-formed UTF-8 at the front of `text`.
bool is_control(std::string_view text, std::size_t length) {
  const auto first = static_cast<unsigned char>(text[0]);
  if (length == 1) return first < 0x20 || first == 0x7F;
  return length == 2 && first == 0xC2 && static_cast<unsigned char>(text[1]) < 0xA0;
}

void append_escape(std::string& out, char c) {
  constexpr std::string_view digits = "0123456789ABCDEF";
  const auto byte = static_cast<unsigned char>(c);
  out += '%';
  out += digits[byte >> 4];
  out += digits[byte & 15];
}

}  // namespace

std::string escape_id(std::string_view path) {
  std::string id;
  id.reserve(path.size());
  while (!path.empty()) {
    const std::size_t length = utf8_sequence_length(path), step = length == 0 ? 1 : length;
    if (length == 0 || is_control(path, length) || escaped_byte(path) >= 0)
      for (const char c : path.substr(0, step)) append_escape(id, c);
    else
      id += path.substr(0, step);
    path.remove_prefix(step);
  }
  return id;
}

std::string unescape_id(std::string_view id) {
  std::string path;
  path.reserve(id.size());
  while (!id.empty()) {
    const int byte = escaped_byte(id);
    path += byte >= 0 ? static_cast<char>(byte) : id[0];
    id.remove_prefix(byte >= 0 ? 3 : 1);
  }
  return path;
}

}  // namespace meander
