// Version of the library as preprocessor macros. The build system reads the version from this file.
#pragma once

#define VOLCCD_VERSION_MAJOR 0
#define VOLCCD_VERSION_MINOR 1
#define VOLCCD_VERSION_PATCH 0
/// For comparisons: VOLCCD_VERSION >= 10000 * major + 100 * minor + patch.
#define VOLCCD_VERSION (10000 * VOLCCD_VERSION_MAJOR + 100 * VOLCCD_VERSION_MINOR + VOLCCD_VERSION_PATCH)
#define VOLCCD_VERSION_STRING "0.1.0"
