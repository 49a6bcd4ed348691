//! The match of the dispatch loop: arms for each form of each scalar operator, derived from the tables
//! of operators and of further steps. The macros that they call are those of the loop.

/// The match on a step: the given arms, and one for each row of the tables.
macro_rules! dispatch {
    ([[$op:expr, { $($control:tt)* }]
      unary { $($(#[$ud:meta])+ $u:ident $us:literal $uf:ident($ut:ident) -> $ur:ident;)* }
      binary { $($(#[$bd:meta])+ $b:ident $bk:ident $bs:literal $bf:ident($bt:ident, $bt2:ident) -> $br:ident;)* }
      compare { $($(#[$cd:meta])+ $c:ident $ck:ident $cj:ident $cjk:ident $cs:literal $cf:ident($ct:ident, $ct2:ident) -> $cr:ident;)* }
      ternary { $($(#[$td:meta])+ $t:ident $ts:literal $tf:ident($tt:ident, $tt2:ident, $tt3:ident) -> $tr:ident;)* }]
      unary { $($xu:ident $xua:ident $xuf:ident -> $xur:ident;)* }
      binary { $($xb:ident $xbk:ident $xbf:ident $ra:ident $ar:ident $aa:ident $ak:ident $kr:ident $ka:ident $rc:ident $ac:ident;)* }
      jump { $($xj:ident $xjk:ident $xjf:ident $jra:ident $jar:ident $jak:ident;)* }
      pair { $($p:ident $pf:ident $pc:ident $q:ident $qk:ident $qf:ident $pra:ident $par:ident $pak:ident;)* }) => {
        match $op {
            $($control)*
            $(Op::$u => store!($ur a, scalar::$uf(r!($ut b))),)*
            $(Op::$b => store!($br a, scalar::$bf(r!($bt b), r!($bt2 c))),
              Op::$bk => store!($br a, scalar::$bf(r!($bt b), k!($bt2))),)*
            $(Op::$c => store!($cr a, scalar::$cf(r!($ct b), r!($ct2 c))),
              Op::$ck => store!($cr a, scalar::$cf(r!($ct b), k!($ct2))),
              Op::$cj => jump_unless!(scalar::$cf(r!($ct a), r!($ct2 b))),
              Op::$cjk => jump_unless!(scalar::$cf(r!($ct a), k!($ct2))),)*
            $(Op::$t => store!($tr imm, scalar::$tf(r!($tt a), r!($tt2 b), r!($tt3 c))),)*
            $(Op::$xua => store!($xur a, scalar::$xuf(acc!())),)*
            $(Op::$ra => store!(Real a, scalar::$xbf(r!(Real b), acc!())),
              Op::$ar => store!(Real a, scalar::$xbf(acc!(), r!(Real c))),
              Op::$aa => store!(Real a, scalar::$xbf(acc!(), acc!())),
              Op::$ak => store!(Real a, scalar::$xbf(acc!(), k!(Real))),
              Op::$kr => {
                  let loaded = load!();
                  store!(Real a, scalar::$xbf(loaded, r!(Real c)))
              }
              Op::$ka => {
                  let loaded = load!();
                  store!(Real a, scalar::$xbf(loaded, acc!()))
              }
              Op::$rc => {
                  let captured = capture!();
                  store!(Real a, scalar::$xbf(r!(Real b), captured))
              }
              Op::$ac => {
                  let captured = capture!();
                  store!(Real a, scalar::$xbf(acc!(), captured))
              })*
            $(Op::$jra => jump_unless!(scalar::$xjf(r!(Real a), acc!())),
              Op::$jar => jump_unless!(scalar::$xjf(acc!(), r!(Real b))),
              Op::$jak => jump_unless!(scalar::$xjf(acc!(), k!(Real))),)*
            $(Op::$pra => {
                  first!(scalar::$pf $pc);
                  store!(Real a, scalar::$qf(r!(Real b), acc!()))
              }
              Op::$par => {
                  first!(scalar::$pf $pc);
                  store!(Real a, scalar::$qf(acc!(), r!(Real c)))
              }
              Op::$pak => {
                  first!(scalar::$pf $pc);
                  store!(Real a, scalar::$qf(acc!(), k!(Real)))
              })*
        }
    };
}
pub(crate) use dispatch;
