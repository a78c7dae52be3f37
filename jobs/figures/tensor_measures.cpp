#include "jobs/figures/figure_set.h"
namespace meander {
void draw_tensor_discrepancy(FigureSet& figures) { figures.begin("Figure 15"); }
void draw_tensor_differences(FigureSet& figures) { figures.begin("Figure 16"); }
}
