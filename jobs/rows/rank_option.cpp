#include "jobs/rows/rank_option.h"

#include <fmt/format.h>

#include <charconv>
#include <string_view>

#include "jobs/cli/usage_error.h"

namespace meander {

namespace {

template <class Number>
bool take_number(std::string_view text, Number& number) {
  const char* const last = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), last, number);
  return error == std::errc() && stop == last;
}

}  // namespace

void add_rank_option(Command& command, std::string& rank) {
  command
      .add_option(
          "--rank", rank,
          "What models are ranked by: plain (the distance), scaled (the distance over the local "
          "scale of both), or diffusion[:k,alpha] (scaled, and diffusion over the graph of the k "
          "nearest neighbors); default: diffusion for the descriptors that are the default, up to 4096 "
          "models, and plain for others")
      .common();
}

RankParameters parse_rank(const std::string& text) {
  constexpr std::string_view with_numbers = "diffusion:";
  if (text == "plain") return {.kind = RankKind::plain};
  if (text == "scaled") return {.kind = RankKind::scaled};
  if (text == "diffusion") return {.kind = RankKind::diffusion};
  const auto refuse = [&] {
    return UsageError(
        fmt::format("--rank: `{}` is not plain, scaled, diffusion or diffusion:K,ALPHA with K from 1 to {} "
                    "and ALPHA from "
                    "{} to {}",
                    text, max_neighbors, min_alpha, max_alpha));
  };
  if (!text.starts_with(with_numbers)) throw refuse();
  const std::string_view numbers = std::string_view(text).substr(with_numbers.size());
  const std::size_t comma = numbers.find(',');
  RankParameters rank{.kind = RankKind::diffusion};
  if (comma == std::string_view::npos || !take_number(numbers.substr(0, comma), rank.neighbors) ||
      !take_number(numbers.substr(comma + 1), rank.alpha) || rank.neighbors < 1 ||
      rank.neighbors > max_neighbors || !(rank.alpha >= min_alpha && rank.alpha <= max_alpha))
    throw refuse();
  return rank;
}

std::string rank_word(const RowRanking& ranking) {
  switch (ranking.kind) {
    case RankKind::plain:
      return "plain";
    case RankKind::scaled:
      return "scaled";
    case RankKind::diffusion:
      return fmt::format("diffusion:{},{}", ranking.neighbors, ranking.alpha);
  }
  return {};
}

std::string rank_text(const RowRanking& ranking) {
  std::string text = "rank " + rank_word(ranking);
  if (ranking.kind == RankKind::diffusion)
    text += fmt::format(" of weight {:.2g}, {:.0f} % of the neighbors mutual", ranking.diffusion_weight,
                        100 * ranking.mutual_share);
  return text;
}

}  // namespace meander
