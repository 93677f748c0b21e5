// The calls of MPI that a simulation over ranks makes. Errors end all ranks, as MPI's own handler does.

#include <mpi.h>

int relievo_mpi_start(int *rank, int *ranks) {
    int started = 0, level = 0;
    if (MPI_Initialized(&started) != MPI_SUCCESS || started) return 0;
    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &level) != MPI_SUCCESS) return 0;
    MPI_Comm_rank(MPI_COMM_WORLD, rank);
    MPI_Comm_size(MPI_COMM_WORLD, ranks);
    return level >= MPI_THREAD_FUNNELED;
}

void relievo_mpi_finish(void) { MPI_Finalize(); }

void relievo_mpi_abort(int code) { MPI_Abort(MPI_COMM_WORLD, code); }

void relievo_mpi_exchange_counts(const int *sent, int *received) {
    MPI_Alltoall(sent, 1, MPI_INT, received, 1, MPI_INT, MPI_COMM_WORLD);
}

void relievo_mpi_exchange(const unsigned char *sent, const int *counts, const int *firsts, unsigned char *received,
                          const int *expected, const int *places) {
    MPI_Alltoallv(sent, counts, firsts, MPI_BYTE, received, expected, places, MPI_BYTE, MPI_COMM_WORLD);
}

void relievo_mpi_gather_counts(int own, int *received) {
    MPI_Allgather(&own, 1, MPI_INT, received, 1, MPI_INT, MPI_COMM_WORLD);
}

void relievo_mpi_gather(const unsigned char *own, int count, unsigned char *received, const int *expected,
                        const int *places) {
    MPI_Allgatherv(own, count, MPI_BYTE, received, expected, places, MPI_BYTE, MPI_COMM_WORLD);
}
