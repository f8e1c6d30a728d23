#include <volccd/peers/peers.hpp>
#include <volccd/program/program.hpp>

int main(int argc, char** argv) {
  volccd::Registry registry = volccd::Registry::standard();
  volccd::add_peers(registry);
  return volccd::program(argc, argv, registry);
}
