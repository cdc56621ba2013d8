// The other half.
#include "cycle_a.h"
