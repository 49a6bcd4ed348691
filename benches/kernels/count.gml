% Counts down from two million: four operators an iteration.
{ /count /n
  n 0 eqi
  { }
  { n 1 subi count count apply } if } /count
2000000 count count apply
