#include <volccd/program/program.hpp>

int main(int argc, char** argv) { return volccd::program(argc, argv, volccd::Registry::standard()); }
