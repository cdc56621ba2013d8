#include "include_error_inner.h"
