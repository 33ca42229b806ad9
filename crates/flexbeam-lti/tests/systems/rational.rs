use crate::plants::{Noise, distance};
use flexbeam_lti::{C64, Error, Rational, Time, Zpk};

/// Coefficients of the product of (s - r), real part.
fn polynomial(roots: &[C64]) -> Vec<f64> {
    let mut p = vec![C64::ONE];
    for r in roots {
        p.push(C64::ZERO);
        for k in (1..p.len()).rev() {
            let previous = p[k - 1];
            p[k] -= r * previous;
        }
    }
    p.iter().map(|c| c.re).collect()
}

fn conjugates(above: &[(f64, f64)]) -> Vec<C64> {
    above.iter().flat_map(|&(re, im)| [C64::new(re, im), C64::new(re, -im)]).collect()
}

#[test]
fn roots_of_planted_polynomials() {
    let roots =
        [C64::from(-1e-3), C64::from(5.0), C64::from(-2000.0), C64::ZERO, C64::new(-1.0, 50.0), C64::new(-1.0, -50.0)];
    let G = Rational::new(vec![0.0, 3.0, 6.0], polynomial(&roots)).unwrap();
    assert_eq!(G.num, [3.0, 6.0]);
    assert!(distance(&G.poles().unwrap(), &roots, 1e-3) < 1e-9, "{:?}", G.poles());
    assert!(distance(&G.zeros().unwrap(), &[C64::from(-2.0)], 1.0) < 1e-15);
}

#[test]
fn a_state_space_has_the_functions_values() {
    let mut noise = Noise(1);
    for (zeros, n) in [(0, 0), (0, 1), (1, 1), (2, 4), (4, 4), (3, 7)] {
        let num: Vec<f64> = (0..=zeros).map(|_| noise.next()).collect();
        let den: Vec<f64> = (0..=n).map(|k| noise.next() * 50_f64.powi(k)).collect();
        let G = Rational::new(num, den).unwrap();
        let system = G.to_state_space(Time::Continuous).unwrap();
        assert_eq!(system.order(), n as usize);
        for _ in 0..4 {
            let s = noise.point() * 40.0;
            let horner =
                G.num.iter().fold(C64::ZERO, |x, a| x * s + a) / G.den.iter().fold(C64::ZERO, |x, a| x * s + a);
            assert!((G.at(s) - horner).norm() < 1e-13 * horner.norm());
            assert!((system.at(s)[0] - horner).norm() < 1e-10 * horner.norm(), "{zeros} {n}");
        }
    }
}

#[test]
fn values_of_high_degree_do_not_overflow() {
    let G = Rational::new([vec![1.0], vec![0.0; 200]].concat(), [vec![2.0], vec![0.0; 201]].concat()).unwrap();
    assert!((G.at(C64::from(1e5)) - 0.5e-5).norm() < 1e-20);
    assert_eq!(G.at(C64::ZERO).re, f64::INFINITY);
}

#[test]
fn functions_without_meaning_are_refused() {
    assert_eq!(Rational::new(vec![1.0], vec![0.0, 0.0]), Err(Error::ZeroDenominator));
    assert_eq!(Rational::new(vec![1.0], vec![]), Err(Error::ZeroDenominator));
    assert!(matches!(Rational::new(vec![1.0], vec![1.0, f64::NAN]), Err(Error::NotFinite { column: 2, .. })));
    let improper = Rational::new(vec![1.0, 0.0, 0.0], vec![1.0, 1.0]).unwrap();
    assert_eq!(improper.to_state_space(Time::Continuous), Err(Error::Improper { zeros: 2, poles: 1 }));
    assert_eq!(Rational::new(vec![], vec![1.0]).unwrap().at(C64::ONE), C64::ZERO);
}

fn zpk(zeros: Vec<C64>, poles: Vec<C64>) -> Zpk {
    Zpk { zeros, poles, gain: 2.5 }
}

fn reals(values: &[f64]) -> Vec<C64> {
    values.iter().copied().map(C64::from).collect()
}

#[test]
fn sections_for_every_mixture_of_real_and_complex_roots() {
    let mut noise = Noise(2);
    let poles = [
        [conjugates(&[(-1.0, 5.0), (-0.1, 40.0)]), reals(&[-3.0])].concat(),
        reals(&[0.0, 0.0, -2.0, -300.0, 7.0]),
        [conjugates(&[(-1.0, 1e-3)]), reals(&[-1.0, -1.0, -1.0])].concat(),
    ];
    let zeros = [
        vec![],
        reals(&[-1.5]),
        reals(&[1.5, -2.0, -7.0]),
        conjugates(&[(0.5, 6.0)]),
        conjugates(&[(0.5, 6.0), (-0.2, 39.0)]),
        [conjugates(&[(0.5, 6.0)]), reals(&[2.0, 3.0, 4.0])].concat(),
    ];
    for poles in &poles {
        for zeros in &zeros {
            let G = zpk(zeros.clone(), poles.clone());
            let system = G.to_state_space(Time::Continuous).unwrap();
            assert_eq!(system.order(), poles.len());
            let s = noise.point();
            let product = |roots: &[C64]| roots.iter().map(|r| s - r).product::<C64>();
            let wanted = product(zeros) / product(poles) * 2.5;
            assert!((G.at(s) - wanted).norm() < 1e-14 * wanted.norm());
            assert!((system.at(s)[0] - wanted).norm() < 1e-12 * wanted.norm(), "{zeros:?} {poles:?}");
        }
    }
}

#[test]
fn forty_light_modes_keep_their_poles_where_coefficients_could_not() {
    let above: Vec<(f64, f64)> = (1..=20).map(|k| (-0.01 * k as f64, 10.0 * k as f64)).collect();
    let G = zpk(vec![], conjugates(&above));
    let system = G.to_state_space(Time::Continuous).unwrap();
    let s = C64::new(0.3, 95.0);
    assert!((system.at(s)[0] - G.at(s)).norm() < 1e-11 * G.at(s).norm());
}

#[test]
fn lonely_complex_roots_and_improper_functions_are_refused() {
    let lonely = zpk(vec![], vec![C64::new(-1.0, 2.0), C64::new(-1.0, 2.0)]);
    assert!(matches!(lonely.to_state_space(Time::Continuous), Err(Error::NotConjugate { what: "pole", .. })));
    let below = zpk(vec![C64::new(-1.0, -2.0)], reals(&[1.0]));
    assert!(matches!(below.to_state_space(Time::Continuous), Err(Error::NotConjugate { what: "zero", .. })));
    let improper = zpk(reals(&[1.0]), vec![]);
    assert_eq!(improper.to_state_space(Time::Continuous), Err(Error::Improper { zeros: 1, poles: 0 }));
    assert_eq!(zpk(vec![], reals(&[1.0])).at(C64::ONE).re, f64::INFINITY);
}
