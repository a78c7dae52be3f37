#include "kernels/core/joined_texts.h"

namespace meander {

namespace {

template <class Text>
std::string joined(std::span<const Text> texts, std::string_view between) {
  std::string all;
  for (const Text& text : texts) {
    if (&text != texts.data()) all += between;
    all += text;
  }
  return all;
}

}  // namespace

std::string joined_texts(std::span<const std::string> texts, std::string_view between) {
  return joined(texts, between);
}

std::string joined_texts(std::span<const std::string_view> texts, std::string_view between) {
  return joined(texts, between);
}

}  // namespace meander
