// Partial factorisations of dense fronts, for the sparse factorisations.
#pragma once

#include <cstddef>

#include "kernels/core/instruction_set.h"

namespace meander {

// Both take the square matrix of `rows` rows at `front`, stored by columns, and eliminate its first `columns`
// <= rows unknowns in place, without pivoting. False, the front half done, when a pivot was not usable. Work:
// about rows^2 * columns multiplications (half of them for factorise_front). Entries are subtracted from in
// an order that only their place and the two sizes decide, so the bits are those of every processor and
// instruction set; a matrix library divides by the sizes of caches, and multiplies and adds in one rounding
// where it can.

// A = L L^T: the columns hold those of L, and the rest is what remains (the Schur complement). Only the lower
// triangle is read; above it the entries are left undefined. A usable pivot is positive.
bool factorise_front(double* front, std::size_t rows, std::size_t columns,
                     InstructionSet set = InstructionSet::automatic);
// A = L R, L of unit diagonal: the columns hold L below the diagonal, the rows R, and the rest is what
// remains. A usable pivot is finite and not zero.
bool eliminate_front(double* front, std::size_t rows, std::size_t columns,
                     InstructionSet set = InstructionSet::automatic);

}  // namespace meander
