// Statuses, methods, repairs and the exception that carries a status out of a kernel, which other programs
// see too.
#pragma once

#include "kernels/public/status.h"
