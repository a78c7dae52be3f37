#include "kernels/tensor/singularities.h"
