#include "jobs/jobs.h"

int main(int argc, char** argv) { return meander::run_program(argc, argv); }
