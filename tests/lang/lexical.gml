% One program a line, and behind `%!` the stack it leaves, or `error CODE at COLUMN`.
1-1 %! 1 -1
-1-1 %! -1 -1
1 /x-1 x-1 %! 1
3 /x 3x %! 3 3
1e3 1E3 1.5e-3 -2.5E2 %! 1000.0 1000.0 0.0015 -250.0
-0 -0.0 %! 0 -0.0
1e300 0.1 1.0 %! 1e300 0.1 1.0
1. %! error E0001 at 2
.5 %! error E0001 at 1
1e+5 %! error E0001 at 3
1 + 2 %! error E0001 at 3
- %! error E0001 at 1
1 # 2 %! error E0001 at 3
"abc %! error E0002 at 1
99999999999999999999 %! error E0003 at 1
1e999 %! error E0003 at 1
/ x %! error E0004 at 1
/1 %! error E0004 at 1
1 /addi %! error E0005 at 3
{ 1 /sphere } %! error E0005 at 5
/true %! error E0005 at 1
1 /Light 2 /addI 3 /unions Light addI unions %! 1 2 3
[ [ { ] } ] %! error E0006 at 7
{ 1 2 %! error E0007 at 1
[ 1 2 %! error E0007 at 1
} %! error E0006 at 1
1 /* a comment */ 2 %! 1 2
1{2}apply[3]%! 1 2 [ 3 ]
1 /a_b-c9 a_b-c9 %! 1
1 /e 123e %! 123 1
1 /e3 1e3 e3 %! 1000.0 1
1.5e2.5 %! error E0001 at 6
1--1 %! error E0001 at 2
x-y %! error E0102 at 1
5 /x/y %! error E0101 at 5
5 /x 6/y x y %! 5 6
addiaddi %! error E0102 at 1
1 2 Addi %! error E0102 at 5
true1 %! error E0102 at 1
3 /true-ish true-ish %! 3
{}[] %! {...} [ ]
{}[]{} %! {...} [ ] {...}
"" "%" "/* */" %! "" "%" "/* */"
1 /* 2 /* 3 */ 4 %! 1 4
1 % 2 /* 3 %! 1
1 */ 2 %! error E0001 at 3
1 /* 2 %! error E0012 at 3
/ %! error E0004 at 1
1 //x %! error E0004 at 3
/-x %! error E0004 at 1
/x- %! error E0101 at 1
-9223372036854775808 9223372036854775807 %! -9223372036854775808 9223372036854775807
9223372036854775808 %! error E0003 at 1
-1e-400 1e-400 %! -0.0 0.0
007 -007 00.50 %! 7 -7 0.5
1 +2 %! error E0001 at 3
1_000 %! error E0001 at 2
_x %! error E0001 at 1
"tab	inside" %! error E0002 at 5
[ } ] %! error E0006 at 3
{ ] } %! error E0006 at 3
1 ] 2 %! error E0006 at 3
[ { 1 ] %! error E0006 at 7
{ { { 1 } %! error E0007 at 3
[ 1 2 } 3 %! error E0006 at 7
"a" "b %! error E0002 at 5
` %! error E0001 at 1
é %! error E0001 at 1
