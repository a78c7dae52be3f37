#include "kernels/tensor/make_tensor_field.h"
