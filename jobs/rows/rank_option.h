// --rank: how rows are ranked, as the option says it and as results name it.
#pragma once

#include <string>

#include "jobs/cli/command_line.h"
#include "kernels/retrieve/row_ranking.h"

namespace meander {

void add_rank_option(Command& command, std::string& rank);

// plain, scaled, diffusion or diffusion:K,ALPHA. Throws UsageError.
RankParameters parse_rank(const std::string& text);

// What was done, as the option would ask for it: diffusion:6,0.85.
std::string rank_word(const RowRanking& ranking);
// The same with what it follows from: "rank diffusion:6,0.85 of weight 0.5, 78 % of the neighbors mutual".
std::string rank_text(const RowRanking& ranking);

}  // namespace meander
