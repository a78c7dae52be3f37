// Cooperative deadline and cancellation, checked between stages and inside long loops: CancelToken.
#pragma once

#include "kernels/public/status.h"
