// A strict reader of the XML that the figures are made of: enough to check that it is well-formed
// and to find elements in it. Independent of the code under test.
#pragma once

#include <cctype>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace meander::test {

struct XmlElement {
  std::string name;
  std::map<std::string, std::string> attributes;
  std::string text;  // all character data inside, entities resolved
};

class XmlReader {
 public:
  // The elements in the order in which they begin. Throws std::runtime_error for anything ill-formed.
  static std::vector<XmlElement> read(std::string_view text) {
    XmlReader reader(text);
    reader.document();
    return reader.elements_;
  }

 private:
  explicit XmlReader(std::string_view text) : rest_(text) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(what + " before: " + std::string(rest_.substr(0, 60)));
  }
  bool take(std::string_view token) {
    if (!rest_.starts_with(token)) return false;
    rest_.remove_prefix(token.size());
    return true;
  }
  void space() {
    while (!rest_.empty() && std::string_view(" \t\r\n").find(rest_[0]) != std::string_view::npos)
      rest_.remove_prefix(1);
  }
  std::string name() {
    std::size_t length = 0;
    while (length < rest_.size() && (std::isalnum(static_cast<unsigned char>(rest_[length])) ||
                                     rest_[length] == '-' || rest_[length] == ':'))
      ++length;
    if (length == 0) fail("no name");
    const std::string found(rest_.substr(0, length));
    rest_.remove_prefix(length);
    return found;
  }
  // Character data up to (not with) one of the stops.
  std::string data(std::string_view stops) {
    std::string out;
    while (!rest_.empty() && stops.find(rest_[0]) == std::string_view::npos) {
      const auto byte = static_cast<unsigned char>(rest_[0]);
      if (rest_[0] == '<') fail("bare <");
      if (byte < 0x20 && byte != '\t' && byte != '\n' && byte != '\r') fail("control character");
      if (take("&amp;"))
        out += '&';
      else if (take("&lt;"))
        out += '<';
      else if (take("&gt;"))
        out += '>';
      else if (take("&quot;"))
        out += '"';
      else if (take("&#39;"))
        out += '\'';
      else if (rest_[0] == '&')
        fail("bare &");
      else {
        out += rest_[0];
        rest_.remove_prefix(1);
      }
    }
    return out;
  }
  void attributes(XmlElement& element) {
    for (space(); !rest_.empty() && rest_[0] != '>' && rest_[0] != '/'; space()) {
      const std::string key = name();
      if (!take("=\"")) fail("no quoted value");
      if (!element.attributes.emplace(key, data("\"")).second) fail("attribute twice");
      if (!take("\"")) fail("value does not end");
    }
  }
  void element() {
    if (!take("<")) fail("no element");
    const std::size_t index = elements_.size();
    elements_.emplace_back();
    elements_[index].name = name();
    attributes(elements_[index]);
    if (take("/>")) return;
    if (!take(">")) fail("tag does not end");
    while (!take("</")) {
      if (rest_.empty()) fail("element does not end");
      if (rest_[0] != '<') {
        elements_[index].text += data("<");
        continue;
      }
      const std::size_t inner = elements_.size();
      element();
      elements_[index].text += elements_[inner].text;
    }
    if (name() != elements_[index].name) fail("other end tag");
    if (!take(">")) fail("end tag does not end");
  }
  void document() {
    if (take("<?xml"))
      rest_.remove_prefix(rest_.find("?>") + 2);
    else if (!take("<!DOCTYPE html>"))
      fail("no declaration");
    space();
    element();
    space();
    if (!rest_.empty()) fail("more than one root");
  }

  std::string_view rest_;
  std::vector<XmlElement> elements_;
};

inline std::vector<XmlElement> named(const std::vector<XmlElement>& elements, std::string_view name) {
  std::vector<XmlElement> found;
  for (const XmlElement& element : elements)
    if (element.name == name) found.push_back(element);
  return found;
}

}  // namespace meander::test
