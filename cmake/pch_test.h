// Precompiled for the test programs.
#include "pch_base.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
