/* Calls a function that no library defines. */
void nobody_has_this(const char *how);
void harm(const char *how) {
  if (how[0] == '!') nobody_has_this(how);
}
