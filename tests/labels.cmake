# The labels of tests in C++, by the names of suites: the one place that says what a name means. CTest reads this file
# after the lists of tests that the programs have printed. Other tests get labels where they are added; these have `tree`
# (of the sources), `program`, `package`, `nightly` (.ci/nightly only), and `long`, too.
#   long            left out of `scripts/test --quick` and by sanitizers: the same code on more data
#   threads         runs under the thread sanitizer, with a std::thread executor
#   kernels         depends on the instruction set: runs for EMU128 as well
#   slow-sanitized  takes long under the address sanitizer, which other tests run the same code under
set(long "^Long")
set(threads "Threads")
set(kernels "^((BroadPhase|ElementCulling|FeatureFilter|NarrowPhase)Promises|ContactHashes)$")
string(CONCAT slow_sanitized
  "^(Harness|SameContacts|QueryMotion|Baselines|RanksExperiment|SubstepsExperiment|ScenesWithTools|Weld|SimulatedSolids)$"
  "|^(Tetrahedra|DeformOnSharedData|Verify|ReferenceContacts|QueryComparison|PeersExperiment)$"
  "|^(InProcessDetector|StageContract|StageObserver|Threads(Pipelines|BoundaryFlood|Workspace|StageObserver))$")
# Single tests, by suite and name.
string(CONCAT slow_sanitized_tests
  "^TopologyLoop\\.CutBlock|^OutOfMemory\\.AnEditThatBringsLargerElements"
  "|^FloodClauses\\.BodiesInsideEachOtherOverManySteps$"
  "|^BoundaryFlood\\.FindsAllContacts(WithAnyElementCulling|OfMeshesMadeToBreakIt)$|^RatioInterval\\.Contains"
  "|^Workspace\\.ASteadyStepAllocatesNothing|^Pipelines\\.ScopesFollow|^SolidBending\\.CantileverOfHexahedra$"
  "|^TopologyLoop\\.BlocksThatHitHard|^ElementBreaking\\.WithinTheLoop"
  "|^Statistics\\.ContactsAtTheStartAreCounted$|^SequenceStepper\\.ProjectileEqualsFreshTopologies$"
  "|^RegionFilter\\.EachTestIsKeptOnceByARankThatHoldsItsElements$|^Pipelines\\.FirstIsTheEarliestOfAll$")

foreach(program IN LISTS programs)
  foreach(test IN LISTS ${program}_TESTS)
    # module.Instance/Suite/0.Test/parameter
    if(NOT test MATCHES "^[a-z0-9_]+\\.([A-Za-z0-9_]+/)?([A-Za-z_][A-Za-z0-9_]*)(/[0-9]+)?\\.([A-Za-z0-9_]+)")
      message(FATAL_ERROR "not a name of a test: ${test}")
    endif()
    set(suite "${CMAKE_MATCH_2}")
    set(name "${CMAKE_MATCH_2}.${CMAKE_MATCH_4}")
    set(labels)
    foreach(label IN ITEMS long threads kernels slow_sanitized)
      if(suite MATCHES "${${label}}" OR (DEFINED ${label}_tests AND name MATCHES "${${label}_tests}"))
        string(REPLACE "_" "-" label "${label}")
        list(APPEND labels "${label}")
      endif()
    endforeach()
    if(labels)
      set_tests_properties("${test}" PROPERTIES LABELS "${labels}")
    endif()
  endforeach()
endforeach()
