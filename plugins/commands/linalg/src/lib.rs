//! Linear algebra for scripts: `require 'matrix'` provides matrices with operators, which use these commands.
//!
//! `decompositions`: the mathematics, without commands; `arguments`: matrices as arguments and results of commands;
//! `matrix.lua`: the matrix type of scripts.

mod arguments;
mod decompositions;

use arguments::{Cmd, Linalg, matrix, matrix_argument, return_matrix, rows};
use tatu_plugin_api::{
    safe::{Fail, Host, Offer, Param, Plugin, Result},
    tatu_plugin,
};

impl Plugin for Linalg {
    fn start(_: &Host) -> Result<Self> {
        Ok(Linalg)
    }

    fn offer(offer: &mut Offer<Self>) {
        offer.subject("linalg", |offer| {
            products(offer);
            of_one(offer);
            eigen(offer);
        });
        offer.prelude("lua", "", "return { api = { 'linalg.' } }");
        offer.prelude("lua", "matrix", include_str!("matrix.lua"));
    }
}

fn products(offer: &mut Offer<Linalg>) {
    offer.command(
        Cmd::side_by_side("linalg.multiply", |c| {
            let (a, b) = (matrix_argument(c, 0)?, matrix_argument(c, 2)?);
            if a.ncols() != b.nrows() {
                let text = format!("a has {} columns and b has {} rows", a.ncols(), b.nrows());
                return Err(Fail::argument(format!("{text}, but a product requires equal numbers")));
            }
            return_matrix(c, &(a * b))
        })
        .param(matrix("a"))
        .param(rows("a_rows"))
        .param(matrix("b"))
        .param(rows("b_rows"))
        .returns(Param::floats("product", 0).text("by rows"))
        .text("Multiplies two matrices, each given by its elements, row by row, and its number of rows.")
        .example("local p = linalg.multiply({1, 2, 3, 4}, 2, {1, 1}, 2)\nassert(p[1] == 3 and p[2] == 7)"),
    );
    offer.command(
        Cmd::side_by_side("linalg.solve", |c| {
            let (a, b) = (matrix_argument(c, 0)?, matrix_argument(c, 2)?);
            let x = decompositions::solve(&a, &b).map_err(Fail::argument)?;
            return_matrix(c, &x)
        })
        .param(matrix("a"))
        .param(rows("a_rows"))
        .param(matrix("b"))
        .param(rows("b_rows"))
        .returns(Param::floats("x", 0).text("by rows"))
        .text("Solves a x = b, in the least-squares sense if a has more rows than columns.")
        .example("local x = linalg.solve({2, 0, 0, 4}, 2, {2, 2}, 2)\nassert(x[1] == 1 and x[2] == 0.5)"),
    );
}

/// An operation that computes a matrix from one matrix.
type MatrixFunction = fn(&decompositions::Matrix) -> std::result::Result<decompositions::Matrix, String>;

fn of_one(offer: &mut Offer<Linalg>) {
    let all: [(&str, MatrixFunction, &str, &str); 4] = [
        ("inverse", decompositions::inverse, "Returns the inverse of a square matrix.", "m = linalg.inverse({4}, 1)"),
        (
            "exponential",
            decompositions::exponential,
            "Returns the exponential of a square matrix: the exact step of a linear system, exp(A dt).",
            "m = linalg.exponential({0, 1, 0, 0}, 2)",
        ),
        (
            "cholesky",
            decompositions::cholesky,
            "Returns the lower triangle L of a symmetric positive definite matrix L L'.",
            "m = linalg.cholesky({4, 0, 0, 9}, 2)",
        ),
        (
            "pseudoInverse",
            decompositions::pseudo_inverse,
            "Returns the Moore-Penrose inverse; singular values below 1e-12 times the greatest one are treated as 0.",
            "m = linalg.pseudoInverse({1, 1}, 2)",
        ),
    ];
    for (name, run, text, example) in all {
        offer.command(
            Cmd::side_by_side(format!("linalg.{name}"), move |c| {
                let made = run(&matrix_argument(c, 0)?).map_err(Fail::argument)?;
                return_matrix(c, &made)
            })
            .param(matrix("m"))
            .param(rows("m_rows"))
            .returns(Param::floats("result", 0).text("by rows"))
            .text(text)
            .example(example),
        );
    }
    offer.command(
        Cmd::side_by_side("linalg.determinant", |c| {
            let d = decompositions::determinant(&matrix_argument(c, 0)?).map_err(Fail::argument)?;
            c.ret(d);
            Ok(())
        })
        .param(matrix("m"))
        .param(rows("m_rows"))
        .returns(Param::float("determinant"))
        .text("Returns the determinant of a square matrix.")
        .example("assert(linalg.determinant({1, 2, 3, 4}, 2) == -2)"),
    );
}

fn eigen(offer: &mut Offer<Linalg>) {
    offer.command(
        Cmd::side_by_side("linalg.eigenvalues", |c| {
            let (real, imaginary) = decompositions::eigenvalues(&matrix_argument(c, 0)?).map_err(Fail::argument)?;
            c.ret(&real[..]);
            c.ret(&imaginary[..]);
            Ok(())
        })
        .param(matrix("m"))
        .param(rows("m_rows"))
        .returns(Param::floats("real", 0).text("real parts, ascending"))
        .returns(Param::floats("imaginary", 0).text("imaginary parts, in the same order"))
        .text("Returns the eigenvalues of a square matrix.")
        .example("local re, im = linalg.eigenvalues({0, 1, -1, 0}, 2)\nassert(math.abs(im[2] - 1) < 1e-12)"),
    );
    offer.command(
        Cmd::side_by_side("linalg.symmetricEigen", |c| {
            let (values, vectors) = decompositions::symmetric_eigen(&matrix_argument(c, 0)?).map_err(Fail::argument)?;
            c.ret(&values[..]);
            return_matrix(c, &vectors)
        })
        .param(matrix("m"))
        .param(rows("m_rows"))
        .returns(Param::floats("values", 0).text("ascending"))
        .returns(Param::floats("vectors", 0).text("row by row: column i belongs to value i"))
        .text("Returns the eigenvalues and eigenvectors of a symmetric matrix.")
        .example("local values = linalg.symmetricEigen({2, 0, 0, 1}, 2)\nassert(values[1] == 1 and values[2] == 2)"),
    );
}

tatu_plugin! {
    plugin: Linalg,
    id: "tatu.commands.linalg",
    name: "Linear algebra",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
