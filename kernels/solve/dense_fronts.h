// Partial factorizations of dense fronts, for the sparse factorizations.
#pragma once

#include <cstddef>

#include "kernels/core/instruction_set.h"

namespace meander {

// Both functions take the square matrix of `rows` rows at `front`, stored by columns, and eliminate its first
// `columns` <= rows unknowns in place, without pivoting. They return false, with the front half done, when a
// pivot is unusable. Work: about rows^2 * columns multiplications (half of them for factorize_front). Only
// the position of an entry and the two sizes decide the order of subtractions from it, so the bits are the
// same with every processor and instruction set. A matrix library divides by the sizes of caches, and
// multiplies and adds in one rounding where it can.

// A = L L^T: the columns hold those of L, and the rest the Schur complement. Only the lower triangle is read;
// above it the entries are left undefined. A usable pivot is positive.
bool factorize_front(double* front, std::size_t rows, std::size_t columns,
                     InstructionSet set = InstructionSet::automatic);
// A = L R with the unit diagonal in L: the columns hold L below the diagonal, the rows hold R, and the rest
// the Schur complement. A usable pivot is finite and not zero.
bool eliminate_front(double* front, std::size_t rows, std::size_t columns,
                     InstructionSet set = InstructionSet::automatic);

}  // namespace meander
