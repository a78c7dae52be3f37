#include "jobs/sequence_options.h"

#include "jobs/option_words.h"

namespace meander {

void add_spacing_option(Command& command, SpacingKind& spacing, bool& given) {
  command
      .add_option(
          "--spacing",
          [&spacing, &given](const std::string& text) {
            spacing = value_of(spacing_words, text);
            given = true;
          },
          "Effort of the sequence spaced")
      .show_default(text_of(spacing_words, spacing))
      .one_of(all_words(spacing_words));
}

void check_spacing_option(SequenceKind sequence, bool given, std::vector<std::string>& problems) {
  if (given && sequence != SequenceKind::spaced)
    problems.push_back("--spacing applies to the sequence spaced: add --sequence spaced");
}

}  // namespace meander
