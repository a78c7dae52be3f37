// The commands of `meander retrieve`, and the scores that two of them print.
#pragma once

#include <string>
#include <vector>

#include "io/table/table.h"
#include "jobs/cli/jobs.h"
#include "kernels/retrieve/retrieval_scores.h"

namespace meander {

// Each adds one command to the parser of `retrieve`; the returned function runs it.
// query: the models of a store that are most similar to its own, or to any mesh.
JobFunction add_query_command(Command& retrieve, const Laboratory* laboratory);
// graph: makes the graph of nearest neighbors that queries are ranked by.
JobFunction add_graph_command(Command& retrieve);
// words: learns the words of local pairs from a store, and codes its models.
JobFunction add_words_command(Command& retrieve);
// select: scores every setting, and judges the choice among them on classes left out.
JobFunction add_select_command(Command& retrieve);

// --classes and --psb-compat.
void add_scoring_options(Command& command, std::string& classes, bool& psb_compat);

// The columns of the scores in a table, and their cells, appended to those of a row.
void add_score_columns(std::vector<TableColumn>& columns);
void add_scores(std::vector<TableCell>& cells, const RetrievalScores& scores);

}  // namespace meander
