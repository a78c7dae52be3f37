// Notes name what a file asked for and did not get, or got by a rule that a reader chose. They are counted by
// name, with one example of each. A row can be `ok` and have notes.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

namespace meander {

// The order is part of the store format: only append.
// A comment names the cases that are counted.
enum class Note : std::uint8_t {
  image_missing,        // images that do not exist
  image_outside,        // images outside of the input, which are not opened
  image_unreadable,     // images that are damaged or cut
  image_unsupported,    // images of a format that is not read
  image_too_large,      // images of more pixels than are decoded
  library_missing,      // material libraries (MTL) that do not exist
  library_outside,      // material libraries outside of the input
  library_unreadable,   // material libraries that cannot be read
  library_too_large,    // material libraries beyond the size that is read
  buffer_missing,       // missing buffers of glTF that the geometry does without
  material_missing,     // materials that faces name and no library has
  material_assumed,     // faces without a material that took the only one of their library
  coordinates_missing,  // textured faces whose corners have no texture coordinates
  feature_ignored,      // extensions or options that change shape, color or samples and are not applied
  color_map_ignored,    // colors that are indices into a color map
  node_repeated,        // nodes of glTF with several parents, drawn below each
  names_dropped,        // names of parts beyond the number of bytes that are kept of a model
  colors_ignored,       // colors that are invalid by the rules of their format
  count
};
inline constexpr std::size_t note_count = static_cast<std::size_t>(Note::count);
inline constexpr std::array<std::string_view, note_count> note_names = {
    "image_missing",    "image_outside",    "image_unreadable",    "image_unsupported", "image_too_large",
    "library_missing",  "library_outside",  "library_unreadable",  "library_too_large", "buffer_missing",
    "material_missing", "material_assumed", "coordinates_missing", "feature_ignored",   "color_map_ignored",
    "node_repeated",    "names_dropped",    "colors_ignored"};
constexpr std::string_view name_of(Note note) { return note_names[static_cast<std::size_t>(note)]; }

// The notes on one model. Memory is bounded: one example of each kind, of at most longest_note_example bytes.
struct Notes {
  static constexpr std::size_t longest_note_example = 160;
  std::array<std::uint32_t, note_count> counts{};  // saturating
  // The example that was added first, as one line of text.
  std::array<std::string, note_count> examples;

  std::uint32_t operator[](Note note) const { return counts[static_cast<std::size_t>(note)]; }
  bool any() const {
    for (const std::uint32_t count : counts)
      if (count > 0) return true;
    return false;
  }
  // Counts a note. `example` says what and why, as "`images/a.png` is not there".
  void add(Note note, std::string_view example, std::uint64_t count = 1) {
    const auto n = static_cast<std::size_t>(note);
    constexpr std::uint32_t max = std::numeric_limits<std::uint32_t>::max();
    if (count == 0) return;
    if (counts[n] == 0) examples[n] = example.substr(0, longest_note_example);
    counts[n] = count < max - counts[n] ? counts[n] + static_cast<std::uint32_t>(count) : max;
  }
};

// Adds the notes of later work on the same model.
inline void add(Notes& notes, const Notes& later) {
  for (std::size_t n = 0; n < note_count; ++n)
    notes.add(static_cast<Note>(n), later.examples[n], later.counts[n]);
}

// A set of kinds of notes, one bit each.
using NoteSet = std::uint64_t;
static_assert(note_count <= 64);
inline constexpr NoteSet every_note = note_count == 64 ? ~NoteSet{0} : (NoteSet{1} << note_count % 64) - 1;
constexpr NoteSet set_of(Note note) { return NoteSet{1} << static_cast<unsigned>(note); }

// The notes that only readers take which were asked for colors.
inline constexpr NoteSet color_notes =
    set_of(Note::image_missing) | set_of(Note::image_outside) | set_of(Note::image_unreadable) |
    set_of(Note::image_unsupported) | set_of(Note::image_too_large) | set_of(Note::library_missing) |
    set_of(Note::library_outside) | set_of(Note::library_unreadable) | set_of(Note::library_too_large) |
    set_of(Note::material_missing) | set_of(Note::material_assumed) | set_of(Note::coordinates_missing) |
    set_of(Note::color_map_ignored) | set_of(Note::colors_ignored);

// "all", or the names of the notes separated by commas, in their order.
inline std::string words_of(NoteSet notes) {
  if (notes == every_note) return "all";
  std::string words;
  for (std::size_t n = 0; n < note_count; ++n)
    if ((notes >> n & 1) != 0) words += (words.empty() ? "" : ",") + std::string(note_names[n]);
  return words;
}

// The notes of these kinds in words, "image_missing 2: `a.png`: it is not there; ...": the kind, its count
// and an example. Empty where there are none.
inline std::string text_of(const Notes& notes, NoteSet kinds = ~NoteSet{0}) {
  std::string text;
  for (std::size_t n = 0; n < note_count; ++n) {
    if (notes.counts[n] == 0 || (kinds >> n & 1) == 0) continue;
    if (!text.empty()) text += "; ";
    text += std::string(note_names[n]) + " " + std::to_string(notes.counts[n]) + ": " + notes.examples[n];
  }
  return text;
}

}  // namespace meander
