// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/scan.h"
