#include "jobs/rows/laboratory.h"

int main(int argc, char** argv) { return meander::run_program(argc, argv, meander::program_laboratory()); }
