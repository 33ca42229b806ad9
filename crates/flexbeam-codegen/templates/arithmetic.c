#if !defined FLT_EVAL_METHOD || FLT_EVAL_METHOD != 0
#error "needs arithmetic in the precision of its operands (FLT_EVAL_METHOD 0): on 32-bit x86, build with -msse2 -mfpmath=sse"
#endif
#if defined __FAST_MATH__ || (defined __FINITE_MATH_ONLY__ && __FINITE_MATH_ONLY__ != 0)
#error "needs IEEE arithmetic: build without -ffast-math and without -ffinite-math-only"
#endif
/* gcc warns of this pragma and heeds -ffp-contract=off alone. */
#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif
