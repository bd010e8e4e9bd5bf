/* The function in C that plugin.c calls to crash. */
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

volatile int zero, sum;
int *volatile nowhere;

__attribute__((noinline)) static int deep(int n) {
  volatile char room[1024];
  room[n % 1024] = (char)n;
  return n < 0 ? 0 : deep(n + 1) + room[n % 1024];
}
static void *thread(void *how) {
  if (strcmp(how, "exit") == 0) exit(0);
  *nowhere = 1;
  return NULL;
}

void harm(const char *how) {
  printf("printed by C\n");
  if (strcmp(how, "null") == 0) *nowhere = 1;
  if (strcmp(how, "divide") == 0) sum = 10 / zero;
  if (strcmp(how, "illegal") == 0) __builtin_trap();
  if (strcmp(how, "abort") == 0) abort();
  if (strcmp(how, "bus") == 0) raise(SIGBUS);
  if (strcmp(how, "deep") == 0) sum = deep(0);
  if (strcmp(how, "exit") == 0) exit(0);
  while (strcmp(how, "hang") == 0) sleep(1);
  if (strcmp(how, "fork") == 0 && fork() == 0) *nowhere = 1;
  if (strncmp(how, "thread ", 7) == 0) {
    pthread_t one;
    pthread_create(&one, NULL, thread, (void *)(how + 7));
    pthread_join(one, NULL);
  }
}
