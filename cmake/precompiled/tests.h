// What nearly every test includes: containers, Eigen, GoogleTest and GoogleMock.
#include "cmake/precompiled/eigen.h"

#include <chrono>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
